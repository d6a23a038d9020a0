//! Vectors and rotations in space. Quaternions have the scalar first.

/// A vector.
pub type Vector = [f64; 3];
/// A matrix, row by row.
pub type Matrix = [Vector; 3];
/// A quaternion.
pub type Quaternion = [f64; 4];

/// `a × b`
#[must_use]
pub fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// `a · b`
#[must_use]
pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a + b`
#[must_use]
pub fn plus(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `s a`
#[must_use]
pub fn times(s: f64, a: Vector) -> Vector {
    a.map(|a| s * a)
}

/// `m v`
#[must_use]
pub fn product(m: &Matrix, v: Vector) -> Vector {
    m.map(|row| dot(row, v))
}

/// The transpose.
#[must_use]
pub fn transposed(m: &Matrix) -> Matrix {
    [0, 1, 2].map(|i| m.map(|row| row[i]))
}

/// The solution of three equations, by Cramer's rule.
#[must_use]
pub fn solved(m: &Matrix, b: Vector) -> Vector {
    let [x, y, z] = transposed(m);
    let determinant = dot(x, cross(y, z));
    [
        dot(b, cross(y, z)) / determinant,
        dot(x, cross(b, z)) / determinant,
        dot(x, cross(y, b)) / determinant,
    ]
}

/// The matrix of a quaternion.
#[must_use]
pub fn matrix([w, x, y, z]: Quaternion) -> Matrix {
    [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - w * z),
            2.0 * (x * z + w * y),
        ],
        [
            2.0 * (x * y + w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - w * x),
        ],
        [
            2.0 * (x * z - w * y),
            2.0 * (y * z + w * x),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ]
}

/// `½ q∘(0, w)`
#[must_use]
pub fn rate([s, u @ ..]: Quaternion, w: Vector) -> Quaternion {
    let [x, y, z] = plus(times(s, w), cross(u, w));
    [-0.5 * dot(u, w), 0.5 * x, 0.5 * y, 0.5 * z]
}

/// A quaternion of the norm 1.
#[must_use]
pub fn unit(q: Quaternion) -> Quaternion {
    let norm = q.iter().map(|q| q * q).sum::<f64>().sqrt();
    q.map(|q| q / norm)
}

/// The four numbers from a place on.
#[must_use]
pub fn quaternion(q: &[f64], first: usize) -> Quaternion {
    core::array::from_fn(|k| q[first + k])
}

/// `p∘q`
#[must_use]
pub fn composed(p: Quaternion, q: Quaternion) -> Quaternion {
    let ([a, b, c, d], [w, x, y, z]) = (p, q);
    [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y + c * w + d * x - b * z,
        a * z + d * w + b * y - c * x,
    ]
}

/// The quaternion of a body turned by a rotation vector in its frame.
#[must_use]
pub fn turned(q: Quaternion, by: Vector) -> Quaternion {
    let angle = dot(by, by).sqrt();
    let [x, y, z] = by.map(|x| {
        if angle > 0.0 {
            x / angle * (angle / 2.0).sin()
        } else {
            0.0
        }
    });
    composed(q, [(angle / 2.0).cos(), x, y, z])
}

/// A position, whose quaternion begins at `rotation`, changed in one coordinate by `by`; in the quaternion, whose scalar has no change of its own, by
/// a turn about an axis of its body.
#[must_use]
pub fn moved(rotation: usize, q: &[f64], place: usize, by: f64) -> Vec<f64> {
    let mut moved = q.to_vec();
    match place.checked_sub(rotation) {
        Some(k @ 1..4) => {
            let axis = core::array::from_fn(|i| if i + 1 == k { by } else { 0.0 });
            let turned = turned(quaternion(q, rotation), axis);
            moved[rotation..rotation + 4].copy_from_slice(&turned);
        }
        _ => moved[place] += by,
    }
    moved
}
