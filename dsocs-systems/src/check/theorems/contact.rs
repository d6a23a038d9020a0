//! The order of contact: the residuals of the discrete equations at nodes of the continuous motion.
//!
//! Three nodes `q(t − h), q(t), q(t + h)` of the continuous motion do not solve the discrete equations. Their
//! residual falls with a power of `h`, the order of contact. For `L_d` it is that of the force at a node,
//! which does not depend on total derivatives (the difference of `h L_d` from the action does:
//! [orders](crate::check::orders) measures it, too).

use crate::check::orders::{NoSmoothState, Order, Part, contacts, expansions};
use crate::check::{CheckedMotion, Measured, Report};
use crate::stability::Bar;

/// The largest deficit of the order against the declared one.
const ORDER_DEFICIT: f64 = 0.1;

/// The orders of contact.
pub fn contact(motion: &CheckedMotion<'_>, report: &mut Report) {
    let bar = Bar::AtLeast(motion.expected.order - ORDER_DEFICIT);
    let measured = || -> Measured<_> {
        let motions = expansions(motion, &motion.states)?;
        Ok(contacts(motion.kernel, &motions, motion.h)?)
    };
    let found = match measured() {
        Ok(found) => found,
        Err(error) if error.is::<NoSmoothState>() => {
            report.note(&error.to_string());
            return;
        }
        Err(error) => {
            report.push("of L_d, on the true motion", Bar::Reported, Err(error));
            return;
        }
    };
    let is_free = motion.constraints() == [0; 3];
    for of in found {
        let what = match of.part {
            Part::Forces => "of L_d: D₁L_d + D₂L_d at nodes of the true motion against the force",
            Part::ExternalForces => "of f_d: the external force there",
            Part::Velocities => "of D_K: constraints on velocities at nodes of the true motion",
            Part::Accelerations => "of D_K: constraints on accelerations there",
            Part::Equations if !is_free => "of D_V: works of Q along virtual displacements there",
            _ => continue,
        };
        match of.order {
            // an equation that holds exactly has no order
            Order::Exact => {}
            Order::Power { power, .. } => report.push(what, bar, Ok(power)),
            Order::Unknown(reason) => report.push(what, Bar::Reported, Err(reason.into())),
        }
    }
}
