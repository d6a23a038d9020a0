//! Random numbers, each a function of a seed and indices only. They are the same on every machine and in any
//! order.

use twox_hash::XxHash3_64;

/// A number of 64 bits, from a seed and three indices.
fn bits(seed: u64, place: [u64; 3]) -> u64 {
    let mut bytes = [0; 24];
    for (bytes, number) in bytes.chunks_exact_mut(8).zip(place) {
        bytes.copy_from_slice(&number.to_le_bytes());
    }
    XxHash3_64::oneshot_with_seed(seed, &bytes)
}

/// The use of a number. Different uses have independent numbers.
#[derive(Clone, Copy)]
enum Stream {
    /// A position in a cell.
    Place = 1,
    /// A round of the network of a permutation.
    Permutation = 2,
}

/// A number in `[0, 1)` for a point and a dimension.
pub fn uniform(seed: u64, point: u64, dimension: u64) -> f64 {
    let bits = bits(seed, [Stream::Place as u64, point, dimension]);
    (bits >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
}

/// The image of `place` under a permutation of `0..count` that belongs to a seed and a dimension.
///
/// It is a Feistel network over the next even number of bits. It is applied again until the result is below `count` (cycle walking: Black and
/// Rogaway 2002). It needs no table, so every point of a Latin hypercube can be computed without the others.
pub fn permuted(seed: u64, dimension: u64, place: u64, count: u64) -> u64 {
    let half = (u64::BITS - (count.max(2) - 1).leading_zeros()).div_ceil(2);
    let mask = (1_u64 << half) - 1;
    let mut place = place;
    loop {
        let (mut left, mut right) = (place >> half, place & mask);
        for round in 0..ROUNDS {
            let key = dimension * ROUNDS + round;
            let mixed = bits(seed, [Stream::Permutation as u64, right, key]) & mask;
            (left, right) = (right, left ^ mixed);
        }
        place = left << half | right;
        if place < count {
            return place;
        }
    }
}

/// Rounds of the network.
const ROUNDS: u64 = 6;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_permutation_meets_every_place_once() {
        for count in [1, 2, 3, 7, 64, 1000] {
            let mut images: Vec<u64> = (0..count).map(|place| permuted(5, 1, place, count)).collect();
            if count == 1000 {
                assert_ne!(
                    images,
                    (0..count)
                        .map(|place| permuted(5, 2, place, count))
                        .collect::<Vec<_>>()
                );
                assert_ne!(
                    images,
                    (0..count)
                        .map(|place| permuted(6, 1, place, count))
                        .collect::<Vec<_>>()
                );
                // no drift: the mean of the first half is that of all
                let mean = images[..500].iter().sum::<u64>() as f64 / 500.0;
                assert!((mean - 499.5).abs() < 50.0, "{mean}");
            }
            images.sort_unstable();
            assert_eq!(images, (0..count).collect::<Vec<_>>());
        }
    }

    #[test]
    fn numbers_fill_their_interval() {
        let numbers: Vec<f64> = (0..10_000).map(|point| uniform(1, point, 0)).collect();
        let mean = numbers.iter().sum::<f64>() / 1e4;
        assert!((mean - 0.5).abs() < 0.01, "{mean}");
        assert!(numbers.iter().all(|number| (0.0..1.0).contains(number)));
        // the content of a sweep depends on these numbers
        assert_eq!(
            bits(1, [1, 2, 3]),
            XxHash3_64::oneshot_with_seed(
                1,
                &[
                    1, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0
                ]
            )
        );
    }
}
