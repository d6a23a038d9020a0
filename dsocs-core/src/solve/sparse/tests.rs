//! Random sparse matrices against the dense elimination.

use super::*;
use crate::solve::unknown::Linearization;

/// The number of rows.
const M: usize = 24;

/// Random numbers (splitmix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A place below `end`.
    fn below(&mut self, end: usize) -> usize {
        usize::try_from(self.next() % end as u64).unwrap()
    }

    /// A number between -1 and 1.
    fn number(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// A permutation.
    fn permutation(&mut self) -> [u16; M] {
        let mut places: [u16; M] = core::array::from_fn(|i| u16::try_from(i).unwrap());
        for i in (1..M).rev() {
            places.swap(i, self.below(i + 1));
        }
        places
    }

    /// Entries on the pairs of two permutations, which are the pivots, and `more` anywhere else.
    fn sparse(&mut self, more: usize) -> Sparse {
        let (rows, columns) = (self.permutation(), self.permutation());
        let pivots: Vec<[u16; 2]> = (0..M).map(|k| [rows[k], columns[k]]).collect();
        let mut entries: BTreeSet<[u16; 2]> = pivots.iter().copied().collect();
        for _ in 0..more {
            entries.insert([0, 1].map(|_| u16::try_from(self.below(M)).unwrap()));
        }
        Sparse::new(M, entries.into_iter().collect::<Vec<_>>().leak(), pivots.leak())
    }
}

/// The update, and the determinant.
fn solved(sparse: &Sparse, entries: &[f64], rows: [f64; M]) -> ([f64; M], Determinant) {
    let mut product = Product::new(sparse.is_odd());
    let fill = |room: &mut [f64]| {
        room.copy_from_slice(entries);
        rows
    };
    let found = sparse.update(fill, |pivot| product.take(pivot));
    assert_eq!(found.rows, rows);
    (found.update, product.value())
}

/// The update and the determinant by dense elimination.
fn densely(sparse: &Sparse, entries: &[f64], rows: [f64; M]) -> (Option<[f64; M]>, Determinant) {
    let jacobian = sparse.dense::<f64, [f64; M]>(entries);
    let determinant = <[f64; M] as Unknown<f64>>::determinant(&jacobian);
    (
        Linearization::<f64, [f64; M]> { rows, jacobian }.update(),
        determinant,
    )
}

#[test]
fn both_eliminations_agree() {
    let mut random = Random(1);
    for round in 0..400 {
        let sparse = random.sparse(round % 60);
        // pivots that dominate their rows: every order is accurate
        let entries: Vec<f64> = sparse
            .entries
            .iter()
            .map(|entry| {
                let is_pivot = sparse.pivots.contains(entry);
                random.number()
                    + if is_pivot {
                        9.0_f64.copysign(random.number())
                    } else {
                        0.0
                    }
            })
            .collect();
        let rows = core::array::from_fn(|_| random.number());
        let (update, determinant) = solved(&sparse, &entries, rows);
        let (expected, reference) = densely(&sparse, &entries, rows);
        for (found, expected) in update.iter().zip(expected.expect("a regular matrix")) {
            assert!(
                (found - expected).abs() < 1e-14,
                "round {round}: {found} {expected}"
            );
        }
        let ratio = determinant.in_units_of(reference.exponent) / reference.value;
        assert!((ratio - 1.0).abs() < 1e-12, "round {round}: {ratio}");
    }
}

#[test]
fn what_the_order_does_not_solve_is_not_told_for_a_solution() {
    let mut random = Random(2);
    let (mut refused, mut taken) = (0, 0);
    for _ in 0..400 {
        let sparse = random.sparse(50);
        // a pivot that is small or zero, where another order would be accurate
        let bad = [0.0, 1e-30, 1e-17, 1e-9, 1e-4][random.below(5)];
        let worst = sparse.pivots[random.below(M / 2)];
        let entries: Vec<f64> = sparse
            .entries
            .iter()
            .map(|entry| if *entry == worst { bad } else { random.number() })
            .collect();
        let rows = core::array::from_fn(|_| random.number());
        let (update, _) = solved(&sparse, &entries, rows);
        if update.iter().any(|x| x.is_nan()) {
            refused += 1;
            continue;
        }
        taken += 1;
        // in units of each row's own terms
        for (row, &right) in sparse.dense::<f64, [f64; M]>(&entries).iter().zip(&rows) {
            let products = || row.iter().zip(&update).map(|(entry, x)| entry * x);
            let size = right.abs() + products().map(f64::abs).sum::<f64>();
            assert!((products().sum::<f64>() + right).abs() <= 2.0 * LEFT * size);
        }
    }
    assert!(refused > 100 && taken > 50, "{refused} {taken}");
}

#[test]
fn a_singular_matrix_has_no_solution() {
    let mut random = Random(3);
    for _ in 0..50 {
        let sparse = random.sparse(30);
        let empty = random.below(M);
        let entries: Vec<f64> = sparse
            .entries
            .iter()
            .map(|&[row, _]| {
                if usize::from(row) == empty {
                    0.0
                } else {
                    random.number()
                }
            })
            .collect();
        let (update, _) = solved(&sparse, &entries, [1.0; M]);
        assert!(update.iter().all(|x| x.is_nan()));
        assert_eq!(densely(&sparse, &entries, [1.0; M]).0, None);
    }
}

#[test]
fn lanes_solve_as_one_trajectory_does() {
    let mut random = Random(4);
    for _ in 0..20 {
        let sparse = random.sparse(40);
        let numbers: Vec<[f64; <Lanes>::LANES]> = sparse
            .entries
            .iter()
            .map(|_| core::array::from_fn(|lane| if lane == 3 { 0.0 } else { random.number() }))
            .collect();
        let fill = |room: &mut [Lanes]| {
            for (place, lanes) in room.iter_mut().zip(&numbers) {
                [*place] = Lanes::from_lanes(|lane| [lanes[lane]]);
            }
            [Lanes::splat(1.0); M]
        };
        let found: Update<[Lanes; M]> = sparse.update(fill, |_| {});
        for lane in 0..<Lanes>::LANES {
            let entries: Vec<f64> = numbers.iter().map(|lanes| lanes[lane]).collect();
            let (alone, _) = solved(&sparse, &entries, [1.0; M]);
            for (together, alone) in found.update.iter().zip(alone) {
                assert_eq!(together.lane(lane).is_nan(), alone.is_nan(), "{lane}");
                assert!(alone.is_nan() || together.lane(lane) == alone, "{lane}");
            }
        }
    }
}
