//! Notes and warnings about the steps of a run.

use dsocs_core::{NearlySingular, Shape, Stop, Unresolved};

use crate::cli::arguments::accuracy::Errors;
use crate::entry::{Method, Plan, Row};
use crate::stability::written_time;
use crate::warnings::Warnings;

/// A run of more steps is announced before it begins.
const MANY_STEPS: f64 = 1e8;

/// A note on a run of many steps.
pub(super) fn many_steps_note(plan: &Plan, t0: f64) -> Option<String> {
    let steps = ((plan.until - t0) / plan.h).abs();
    (steps > MANY_STEPS && !matches!(plan.method, Method::Tolerance(_))).then(|| {
        format!(
            "note: this run has {steps:.1e} steps; Ctrl-C ends it, and what is computed by then is written (`--until` and `--step` give fewer, `--every` \
             writes fewer rows)"
        )
    })
}

/// The observers of every node, which give notes at the end.
pub(super) struct RunObservers {
    pub(super) irregular_nodes: IrregularNodes,
    pub(super) errors: Errors,
    pub(super) warnings: Warnings,
}

impl RunObservers {
    /// The observers for a run of a system as planned.
    pub(super) fn of(plan: &Plan, shape: &Shape) -> Self {
        let mut warnings = Warnings::of(plan.method, shape);
        if !plan.inputs.is_empty() {
            warnings.drive(&[]);
        }
        Self {
            irregular_nodes: IrregularNodes::default(),
            errors: Errors::default(),
            warnings,
        }
    }

    /// Looks at a node.
    pub(super) fn look(&mut self, row: &Row<'_>) {
        self.irregular_nodes.look(row);
        self.errors.look(row);
        self.warnings.look(&row.node, || *row);
    }
}

/// The nodes at which a certified run is not regular.
#[derive(Default)]
pub(super) struct IrregularNodes {
    /// The first of them: its number, its time, and which of the flows (forward, backward) is not granted.
    first: Option<(u64, f64, &'static str)>,
    /// The number of such nodes.
    count: u64,
}

impl IrregularNodes {
    /// Looks at a node. The start has no step that could be regular; of third order, neither has the node
    /// after it, which the given acceleration determines.
    pub(super) fn look(&mut self, row: &Row<'_>) {
        let Some(regularity) = row.regularity.filter(|_| row.node.stop != Stop::Start) else {
            return;
        };
        let third = row.declaration.shape().is_of_third_order();
        let which = match (regularity.grants_forward(), regularity.grants_backward(), third) {
            (true, true, _) => return,
            (false, true, false) => "D₃ is singular, no forward flow is granted",
            (false, true, true) => "D₄ is singular, no forward flow is granted",
            (true, false, _) => "D₁ is singular, no backward flow is granted",
            (false, false, false) => "D₃ and D₁ are singular, no flow is granted",
            (false, false, true) => "D₄ and D₁ are singular, no flow is granted",
        };
        self.first.get_or_insert((row.node.index, row.node.t, which));
        self.count += 1;
    }

    /// The note at the end of the run.
    pub(super) fn note(&self) -> Option<String> {
        let (index, t, which) = self.first?;
        Some(format!(
            "note: regularity is lost at {} node{}, first at node {index}, t = {t}: {which}",
            self.count,
            if self.count == 1 { "" } else { "s" }
        ))
    }
}

/// A warning about steps within which a function jumps.
pub(super) fn jump_warning(
    Unresolved {
        steps,
        first,
        largest,
        largest_at,
    }: Unresolved,
    third: bool,
    method: Method,
) -> String {
    // no method follows the continuous motion of a third-order system
    let [ends, goes_on] = if third {
        ["end the run before", "a smaller `--step`"]
    } else {
        [
            "`--tolerance` goes on where the force is finite, and ends where the motion does",
            "`--tolerance` goes on from the place of the jump itself; or a smaller `--step`; `--estimate-error` measures what it costs",
        ]
    };
    let plural = if steps == 1 { "" } else { "s" };
    let [first, worst] = [first, largest_at].map(written_time);
    if largest.is_infinite() {
        let place = if worst == first {
            format!("within {steps} step{plural} that the run has passed, first about t = {first}")
        } else {
            format!(
                "about t = {worst}, in one of {steps} steps within which something jumps, the first of them about t = {first}"
            )
        };
        return format!(
            "warning: a force is infinite, or very large for a short time, or the velocity has to jump, {place}: what \
             comes after depends on where the nodes lie ({ends})"
        );
    }
    // a jump in a derivative of the Lagrangian does not lower the order of the step of order 2
    let at_best = if matches!(method, Method::Composed(_)) {
        ", or of the second at best"
    } else {
        ""
    };
    format!(
        "warning: a force or a constraint jumps, or varies too fast for the nodes, within {steps} step{plural}, first about t = {first}: a jump costs an error \
         of the first order in the step{at_best}, a root of zero, whose rate has no bound, one of an order between 1 and 2; what has its peak or its \
         period between two nodes is lost, and the motion may be another one ({goes_on})"
    )
}

/// A warning about steps in which the equations were nearly singular.
pub(super) fn singularity_warning(
    NearlySingular {
        steps,
        first,
        of_step,
    }: NearlySingular,
    may_divide: bool,
    third: bool,
) -> String {
    let (plural, first) = (if steps == 1 { "" } else { "s" }, written_time(first));
    if of_step == steps {
        return format!(
            "warning: the equations of the step pass through a singularity in {steps} step{plural}, first about t = {first}, where those of the continuous motion have none: \
             a force changes too fast with the velocity for this step, or the velocity grows beyond all bounds, and what comes after may not be the motion (a smaller \
             `--step`{})",
            if third {
                ""
            } else {
                "; `--tolerance 1e-9` ends where the motion does"
            }
        );
    }
    let factor = if may_divide {
        "; a factor of a constraint that vanishes with positions or velocities may be divided out, `branch = divide(factor)`"
    } else {
        ""
    };
    format!(
        "warning: the equations are nearly singular in {steps} step{plural}, first about t = {first}: they hardly determine the {} there, and the error of \
         the motion may be much larger than elsewhere, with that of multipliers (a smaller `--step` shows it{factor})",
        if third { "jerk" } else { "acceleration" }
    )
}
