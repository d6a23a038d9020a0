//! Maps and sets that hash quickly: their keys are small numbers, which nobody chooses to collide.

pub(crate) use rustc_hash::{FxBuildHasher, FxHashMap as HashMap, FxHashSet as HashSet};
