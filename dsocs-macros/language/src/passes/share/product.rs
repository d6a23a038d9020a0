//! Products as lists of factors.

use super::Factor;

/// A product: its different factors in order, each with its multiplicity.
#[derive(Clone, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) struct Product(Vec<(Factor, u32)>);

impl Product {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    fn place(&self, factor: &Factor) -> Result<usize, usize> {
        self.0.binary_search_by(|(own, _)| own.cmp(factor))
    }

    /// Sets the multiplicity of a factor.
    pub(crate) fn insert(&mut self, factor: Factor, count: u32) {
        match self.place(&factor) {
            Ok(place) => self.0[place].1 = count,
            Err(place) => self.0.insert(place, (factor, count)),
        }
    }

    /// The multiplicity of a factor, if it occurs.
    pub(crate) fn get(&self, factor: &Factor) -> Option<&u32> {
        Some(&self.0[self.place(factor).ok()?].1)
    }

    pub(crate) fn get_mut(&mut self, factor: &Factor) -> Option<&mut u32> {
        let place = self.place(factor).ok()?;
        Some(&mut self.0[place].1)
    }

    /// The number of different factors.
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (&Factor, &u32)> {
        self.0.iter().map(|(factor, count)| (factor, count))
    }

    pub(crate) fn keys(&self) -> impl Iterator<Item = &Factor> {
        self.0.iter().map(|(factor, _)| factor)
    }

    pub(crate) fn values(&self) -> impl Iterator<Item = &u32> {
        self.0.iter().map(|(_, count)| count)
    }

    pub(crate) fn retain(&mut self, mut keep: impl FnMut(&Factor, &mut u32) -> bool) {
        self.0.retain_mut(|(factor, count)| keep(factor, count));
    }
}

impl Extend<(Factor, u32)> for Product {
    /// Of repeated factors the last multiplicity holds.
    fn extend<I: IntoIterator<Item = (Factor, u32)>>(&mut self, factors: I) {
        self.0.extend(factors);
        if self.0.is_sorted_by(|(a, _), (b, _)| a < b) {
            return;
        }
        self.0.sort_by(|(a, _), (b, _)| a.cmp(b));
        self.0.dedup_by(|next, first| {
            let same = next.0 == first.0;
            if same {
                first.1 = next.1;
            }
            same
        });
    }
}

impl FromIterator<(Factor, u32)> for Product {
    fn from_iter<I: IntoIterator<Item = (Factor, u32)>>(factors: I) -> Self {
        let mut product = Self::new();
        product.extend(factors);
        product
    }
}

impl<const N: usize> From<[(Factor, u32); N]> for Product {
    fn from(factors: [(Factor, u32); N]) -> Self {
        factors.into_iter().collect()
    }
}

impl IntoIterator for Product {
    type Item = (Factor, u32);
    type IntoIter = std::vec::IntoIter<(Factor, u32)>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl<'p> IntoIterator for &'p Product {
    type Item = (&'p Factor, &'p u32);
    type IntoIter =
        std::iter::Map<std::slice::Iter<'p, (Factor, u32)>, fn(&'p (Factor, u32)) -> (&'p Factor, &'p u32)>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter().map(|(factor, count)| (factor, count))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_stand_in_order_and_the_last_count_holds() {
        let [a, b, c] = [3, 1, 2].map(Factor::Part);
        let mut product = Product::from([(a.clone(), 1), (b.clone(), 2), (a.clone(), 4)]);
        product.insert(c.clone(), 3);
        product.insert(b.clone(), 5);
        let factors: Vec<_> = product.into_iter().collect();
        assert_eq!(factors, [(b, 5), (c, 3), (a, 4)]);
    }
}
