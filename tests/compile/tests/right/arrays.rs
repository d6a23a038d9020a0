//! Arrays of coordinates, sums over ranges and functions of the declaration, also from a macro by example.

use dsocs_core::{Real, System, dsocs};

fn law<R: Real>(x: R, weight: R) -> R {
    x * x * weight
}

/// A row of masses between springs, the first of which is held by a constraint.
#[dsocs {
    coordinates(x, y: [3], z);
    let stretch = |i| if i == 0 { y[0] - x } else { y[i] - y[i - 1] };
    lagrangian = (dot(x).powi(2) + dot(z).powi(2)) / 2 + sum(0..3, |i| masses[i] / 2 * dot(y[i]).powi(2))
        - sum(0..=2, |i| springs[i] / 2 * stretch(i).powi(2) + law(stretch(i), i + 1));
    kinematic = [ddot(x) + sum(0..3, |i| dot(y[i])), ddot(z) + product(0..2, |i| y[i])];
    variational = [(x, |i| y[i], 0), (0, [1, y[0], y[1]], z), (0, [0; 3], 1)];
    phi_lagrangian = |q0, q1| ((q0 + q1) / 2, (q1 - q0) / h);
    phi_kinematic = |q0, q1, q2| {
        let slope = |a, b| (b - a) / h;
        ((q1.x, [q1.y[0], q1.y_1, q1.y[2]], q1), (slope(q0, q1) + slope(q1, q2)) / 2, slope(slope(q0, q1), slope(q1, q2)))
    };
}]
pub struct Row<const N: usize> {
    pub masses: [f64; N],
    pub springs: [f64; 3],
}

#[rustfmt::skip] // which would move the lines of the attribute further each time
macro_rules! oscillators {
    ($name:ident; $n:literal) => {
        #[dsocs {
            coordinates(q: [$n]);
            lagrangian = sum(0..$n, |i| dot(q[i]).powi(2) - stiffness[i] * q[i].powi(2)) / 2;
        }]
        pub struct $name {
            pub stiffness: [f64; $n],
        }
    };
}

oscillators!(Four; 4);

#[test]
fn works() {
    let row = Row {
        masses: [1.0, 2.0, 3.0],
        springs: [1.0; 3],
    };
    assert_eq!(
        Row::<3>::COORDINATES.map(|coordinate| coordinate.name),
        ["x", "y_0", "y_1", "y_2", "z"]
    );
    assert_eq!(
        row.lagrangian(0.0, &[0.0, 1.0, 1.0, 2.0, 0.0], &[1.0; 5]),
        4.0 - (0.5 + 1.0) - (0.5 + 3.0)
    );
    let four = Four {
        stiffness: [1.0, 2.0, 3.0, 4.0],
    };
    assert_eq!(four.energy(0.0, &[1.0; 4], &[1.0; 4]), 7.0);
    assert_eq!(four.parameter(3), Some(4.0));
}
