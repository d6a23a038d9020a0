//! Maps and sets with a fast hash: their keys are small numbers, so nobody can choose keys that collide.

pub(crate) use rustc_hash::{FxBuildHasher, FxHashMap as HashMap, FxHashSet as HashSet};
