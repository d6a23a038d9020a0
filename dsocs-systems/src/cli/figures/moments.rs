//! A sample of the nodes of a run, of bounded size.

/// Nodes at equal distances, at most a given number of them however long the run is, and the last one.
pub struct Moments {
    /// The largest number of nodes kept.
    most: usize,
    /// The distance of two kept nodes, in steps.
    every: u64,
    /// The values at the nodes that are kept.
    rows: Vec<Vec<f64>>,
    /// The values at the last node, if it is not among them.
    last: Option<Vec<f64>>,
}

impl Moments {
    /// An empty sample of at most `most` nodes and the last one.
    pub fn new(most: usize) -> Self {
        Self {
            most: most.max(2),
            every: 1,
            rows: Vec::new(),
            last: None,
        }
    }

    /// Takes the values at a node.
    pub fn push(&mut self, index: u64, values: Vec<f64>) {
        if !index.is_multiple_of(self.every) {
            self.last = Some(values);
            return;
        }
        self.last = None;
        if self.rows.len() >= self.most {
            let mut place = 0;
            self.rows.retain(|_| {
                place += 1;
                place % 2 == 1
            });
            self.every *= 2;
            if !index.is_multiple_of(self.every) {
                self.last = Some(values);
                return;
            }
        }
        self.rows.push(values);
    }

    /// The values that were kept, in the order of the nodes.
    pub fn into_rows(mut self) -> Vec<Vec<f64>> {
        self.rows.extend(self.last);
        self.rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_bounded_and_keep_the_first_and_the_last() {
        // the numbers of nodes are exact
        #[allow(clippy::float_cmp)]
        for count in [1, 2, 99, 100, 101, 12_345] {
            let mut moments = Moments::new(100);
            for index in 0..count {
                moments.push(index, vec![index as f64]);
            }
            let times: Vec<f64> = moments.into_rows().iter().map(|row| row[0]).collect();
            assert!(
                times.len() <= 101 && times.len() as u64 >= count.min(50),
                "{}",
                times.len()
            );
            assert_eq!((times[0], times[times.len() - 1]), (0.0, count as f64 - 1.0));
            let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let [whole @ .., _] = &steps[..] else { continue };
            assert!(whole.iter().all(|step| *step == whole[0]), "{steps:?}");
        }
    }
}
