//! A robot's arm of two links whose tip follows a curve in time: the torques of its motors are constraint forces.

use dsocs_core::dsocs;

/// The tip goes round a circle in the plane of the arm.
#[cfg(feature = "dsocs")]
#[must_use]
pub fn entry() -> crate::Entry {
    let arm = Arm::default();
    let (q, v) = arm.at(0.0);
    crate::Entry::new(arm)
        .named("arm")
        .described("an arm of two links whose tip goes round a circle, and the torques of its motors")
        .source("textbooks on robots, e.g. Spong, Hutchinson and Vidyasagar, Robot Modeling and Control, section 7.4")
        .start(q, v)
        .step(0.005)
        .until(5.0)
}

/// An arm of two uniform links in a vertical plane, with a motor in the shoulder and one in the elbow.
///
/// Two holonomic constraints that depend on time put the tip on the circle `(x₀ + r cos ωt, y₀ + r sin ωt)`, so no
/// degree of freedom is left, and positions at nodes are exact. The result of a run is the force: the generalized constraint force at a
/// node *is* the vector of the motors' torques, because `alpha` is the angle of the first link and `beta` that of the second relative to the
/// first (computed torque, inverse dynamics). Its error is of second order in the step. `λ_0`, `λ_1` are the components of the equivalent
/// force at the tip, in N.
#[dsocs {
    coordinates(
        /// The angle of the first link from the horizontal [rad].
        alpha,
        /// The angle of the second link relative to the first [rad].
        beta,
    );
    // both links are uniform rods
    let elbow_x = length_1 * alpha.cos();
    let elbow_y = length_1 * alpha.sin();
    let tip_x = elbow_x + length_2 * (alpha + beta).cos();
    let tip_y = elbow_y + length_2 * (alpha + beta).sin();
    let turn_1 = mass_1 * length_1.powi(2) / 24 * dot(alpha).powi(2);
    let turn_2 = mass_2 * length_2.powi(2) / 24 * (dot(alpha) + dot(beta)).powi(2);
    let speed_1 = (dot(elbow_x).powi(2) + dot(elbow_y).powi(2)) / 4;
    let speed_2 = ((dot(elbow_x) + dot(tip_x)).powi(2) + (dot(elbow_y) + dot(tip_y)).powi(2)) / 4;
    let height = mass_1 * elbow_y / 2 + mass_2 * (elbow_y + tip_y) / 2;
    lagrangian = mass_1 / 2 * speed_1 + mass_2 / 2 * speed_2 + turn_1 + turn_2 - gravity * height;
    holonomic = [
        tip_x - center_x - radius * (rate * t).cos(),
        tip_y - center_y - radius * (rate * t).sin(),
    ];
    /// The horizontal position of the tip [m].
    let x = tip_x;
    /// The height of the tip [m].
    let y = tip_y;
    observe = [x, y];
}]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arm {
    /// The mass of the first link \[kg\].
    pub mass_1: f64,
    /// The mass of the second link \[kg\].
    pub mass_2: f64,
    /// The length of the first link \[m\].
    pub length_1: f64,
    /// The length of the second link \[m\].
    pub length_2: f64,
    /// The acceleration of gravity [m/s²].
    pub gravity: f64,
    /// The horizontal position of the circle's centre \[m\].
    pub center_x: f64,
    /// The height of the circle's centre \[m\].
    pub center_y: f64,
    /// The radius of the circle \[m\].
    pub radius: f64,
    /// The angular velocity on the circle [rad/s].
    pub rate: f64,
}

impl Default for Arm {
    /// Links of half a metre, the circle in front of the shoulder.
    fn default() -> Self {
        Self {
            mass_1: 2.0,
            mass_2: 1.5,
            length_1: 0.5,
            length_2: 0.4,
            gravity: 9.81,
            center_x: 0.55,
            center_y: 0.1,
            radius: 0.15,
            rate: 2.0,
        }
    }
}

impl Arm {
    /// The angles and their rates at a time, by inverse kinematics: the arm with its elbow below (`β > 0`).
    ///
    /// They are not numbers where the tip is out of reach.
    #[must_use]
    pub fn at(&self, t: f64) -> ([f64; 2], [f64; 2]) {
        let (sin, cos) = (self.rate * t).sin_cos();
        let (r, w) = (self.radius, self.radius * self.rate);
        let (x, y) = (self.center_x + r * cos, self.center_y + r * sin);
        let (l1, l2) = (self.length_1, self.length_2);
        let bend = (x * x + y * y - l1 * l1 - l2 * l2) / (2.0 * l1 * l2);
        let beta = bend.acos();
        let alpha = y.atan2(x) - (l2 * beta.sin()).atan2(l1 + l2 * beta.cos());
        // the Jacobian of the tip, whose determinant is l1 l2 sin β
        let [u, v] = [-w * sin, w * cos];
        let (far, near) = ((alpha + beta).sin_cos(), alpha.sin_cos());
        let determinant = l1 * l2 * beta.sin();
        let alpha_rate = (l2 * far.1 * u + l2 * far.0 * v) / determinant;
        let beta_rate = -((l1 * near.1 + l2 * far.1) * u + (l1 * near.0 + l2 * far.0) * v) / determinant;
        ([alpha, beta], [alpha_rate, beta_rate])
    }
}
