//! Sets of leaves. Many expressions depend on the same leaves, so each set is kept once, and a node keeps its
//! number.

use std::rc::Rc;

use crate::hash::HashMap;

/// The number of a set in [`Sets`].
#[derive(Clone, Copy, Default, PartialEq, Eq, Debug)]
pub(super) struct Set(u32);

impl Set {
    /// The empty set.
    pub(super) const EMPTY: Self = Self(0);

    pub(super) fn index(self) -> usize {
        self.0 as usize
    }
}

/// Sets of leaves as bits, each kept once.
#[derive(Clone, Debug)]
pub(super) struct Sets {
    /// The words of each set, without trailing zeros.
    words: Vec<Rc<[u64]>>,
    known: HashMap<Rc<[u64]>, Set>,
    /// Scratch space, in which a union is formed.
    union: Vec<u64>,
}

impl Default for Sets {
    fn default() -> Self {
        let empty: Rc<[u64]> = Rc::default();
        Self {
            words: vec![Rc::clone(&empty)],
            known: HashMap::from_iter([(empty, Set::EMPTY)]),
            union: Vec::new(),
        }
    }
}

impl Sets {
    /// The set of one leaf, by its bit.
    pub(super) fn single(&mut self, bit: usize) -> Set {
        self.union.clear();
        self.union.resize(bit / 64 + 1, 0);
        self.union[bit / 64] = 1 << (bit % 64);
        self.intern()
    }

    /// The union of sets.
    pub(super) fn union(&mut self, sets: impl IntoIterator<Item = Set>) -> Set {
        // mostly there are one or two different sets, one after the other
        let (mut last, mut several) = (Set::EMPTY, false);
        for set in sets {
            if set == last || set == Set::EMPTY {
                continue;
            }
            if last != Set::EMPTY {
                if !several {
                    several = true;
                    self.union.clear();
                    self.union.extend_from_slice(&self.words[last.index()]);
                }
                let words = &self.words[set.index()];
                if self.union.len() < words.len() {
                    self.union.resize(words.len(), 0);
                }
                for (word, more) in self.union.iter_mut().zip(&**words) {
                    *word |= more;
                }
            }
            last = set;
        }
        if several { self.intern() } else { last }
    }

    /// The number of the set in the scratch space, which is added if it is new.
    fn intern(&mut self) -> Set {
        if let Some(&known) = self.known.get(self.union.as_slice()) {
            return known;
        }
        let set = Set(u32::try_from(self.words.len()).unwrap_or(u32::MAX));
        let words: Rc<[u64]> = self.union.as_slice().into();
        self.words.push(Rc::clone(&words));
        self.known.insert(words, set);
        set
    }

    /// The number of words of a set.
    pub(super) fn size(&self, set: Set) -> usize {
        self.words[set.index()].len()
    }

    pub(super) fn contains(&self, set: Set, bit: usize) -> bool {
        let word = self.words[set.index()].get(bit / 64);
        word.is_some_and(|word| word >> (bit % 64) & 1 == 1)
    }

    /// The bits of a set, in ascending order.
    pub(super) fn bits(&self, set: Set) -> impl Iterator<Item = usize> {
        self.words[set.index()]
            .iter()
            .enumerate()
            .flat_map(|(place, &word)| {
                let mut left = word;
                std::iter::from_fn(move || {
                    let bit = (left != 0).then(|| left.trailing_zeros() as usize)?;
                    left &= left - 1;
                    Some(64 * place + bit)
                })
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_sets_have_one_number() {
        let mut sets = Sets::default();
        let [a, b, c] = [3, 70, 200].map(|bit| sets.single(bit));
        let (ab, ba) = (sets.union([a, b, a]), sets.union([b, Set::EMPTY, a]));
        assert_eq!(ab, ba);
        assert_eq!(sets.union([a, a]), a);
        assert_eq!(sets.union([]), Set::EMPTY);
        let all = sets.union([ab, c]);
        assert_eq!(sets.bits(all).collect::<Vec<_>>(), [3, 70, 200]);
        assert!(sets.contains(all, 70) && !sets.contains(ab, 200));
        assert_eq!(sets.size(ab), 2);
    }
}
