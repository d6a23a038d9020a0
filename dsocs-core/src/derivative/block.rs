//! The linearization of up to eight steps of a path at once.

// inlined, so that it is compiled for the instructions of the machine
#![allow(clippy::inline_always)]

use super::memory::StepSlice;
use super::turning::{self, Legs};
use crate::number::dispatch::{self, Work};
use crate::solve::rotation::{LegTangent, SLOTS};
use crate::tape::declaration::Declaration;
use crate::tape::{Differential, Eight, Input, Leaf, Part, Segment, Sweeps, Tape, Workspace};

/// The meaning of an input of a differential in a step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Role {
    Node(usize),
    Increment(usize),
    Difference(usize),
    Unknown(usize),
    /// A constant or a parameter. Constants are numbered first, then parameters.
    Fixed(usize),
    /// The time or the step `h`, with respect to which nothing is differentiated.
    Still,
}

/// The differentials of the steps of a system.
#[derive(Clone, Debug)]
pub(super) struct Equations {
    /// The rows of a step, followed by the components of the second difference.
    step: Differential,
    /// The point of a node: position, velocity and acceleration.
    pub(super) point: Differential,
    /// The constants, which are computed once, before the run.
    constants: Differential,
    /// The roles of the inputs of `step` and `point`.
    of_step: Vec<Role>,
    pub(super) of_point: Vec<Role>,
    /// The derivatives of rows and components: a matrix by unknowns, node and increment, then those by constants and parameters.
    sweeps: Sweeps,
    by_fixed: Vec<ByFixed>,
    /// The number of coordinates.
    pub coordinates: usize,
    /// The first places of rotations. Changes and derivatives by rotations are those of turns in the frames
    /// of their bodies.
    pub rotations: Vec<usize>,
    /// The number of rows.
    pub rows: usize,
    /// The number of constants.
    count: usize,
    /// The number of parameters.
    pub parameters: usize,
}

/// The working memory of the differentials.
#[derive(Clone, Debug, Default)]
pub(super) struct Rooms {
    step: Workspace,
    pub(super) point: Workspace,
    constants: Workspace,
    /// The quaternions at the points that were evaluated last.
    pub(super) quaternions: Vec<[Eight; SLOTS]>,
}

/// The values of the constants and of the parameters, on a stretch of the path.
pub(super) type Fixed = Vec<f64>;

/// Up to eight consecutive steps with the same parameters.
pub(super) struct Steps<'p> {
    /// The declaration, with the values of its parameters.
    pub declaration: Declaration<'p>,
    /// The steps.
    pub recorded: StepSlice<'p>,
}

/// The derivative of a row, or of a component of the second difference, by a constant or a parameter.
#[derive(Clone, Copy, Debug)]
struct ByFixed {
    row: usize,
    fixed: usize,
    /// Its index in the entries.
    place: usize,
}

/// The linearization of up to eight steps: `δe = ∂e/∂q δq + ∂e/∂d δd + …`.
#[derive(Clone, Debug, Default)]
pub(super) struct Block {
    /// For each component `e_i`, its derivatives by the coordinates of the node, then by those of the increment.
    slopes: Vec<Eight>,
    /// The weight of each row in each component: a change `δr` of row `r` changes `e_i` by `−in_rows[i][r] δr`.
    in_rows: Vec<Eight>,
    /// The derivatives, at the indices that [`Equations::sweeps`] gives. Other entries are zero.
    entries: Vec<Eight>,
    /// The tangents of rotations on the legs to the last nodes.
    legs: Vec<LegTangent<Eight>>,
    /// Working memory of the elimination.
    right: Vec<Eight>,
    /// One number for each row: working memory.
    of_rows: Vec<Eight>,
}

impl Equations {
    pub fn new(tape: &Tape, coordinates: usize, parameters: usize, rotations: &[usize]) -> Self {
        let count = tape.count(Segment::Constants, Part::All);
        let role = |input: Input| match input {
            Input::Constant(place) => Role::Fixed(place),
            Input::Leaf(Leaf::Parameter(place)) => Role::Fixed(count + place),
            Input::Leaf(Leaf::N(i)) => Role::Node(i),
            Input::Leaf(Leaf::D(i)) => Role::Increment(i),
            Input::Leaf(Leaf::E(i)) => Role::Difference(i),
            Input::Leaf(Leaf::Z(i)) => Role::Unknown(i),
            Input::Leaf(_) => Role::Still,
        };
        let is_moving = |input: Input| role(input) != Role::Still;
        let rows = (Segment::Residual, Part::Head);
        let step = tape.differential(&[rows, (Segment::SecondDifference, Part::All)], &is_moving);
        let point = tape.differential(&[(Segment::Node, Part::Head)], &is_moving);
        let of_step: Vec<Role> = step.inputs().map(role).collect();
        let unknowns = tape.count(rows.0, rows.1);
        let (width, mut by_fixed) = (unknowns + 2 * coordinates, Vec::new());
        let matrix = (unknowns + coordinates) * width;
        let sweeps = step.sweeps(&mut |row, input| match of_step[input] {
            Role::Fixed(fixed) => {
                let place = matrix + by_fixed.len();
                by_fixed.push(ByFixed { row, fixed, place });
                Some(place)
            }
            Role::Unknown(place) => Some(row * width + place),
            Role::Node(place) => Some(row * width + unknowns + place),
            Role::Increment(place) => Some(row * width + unknowns + coordinates + place),
            Role::Difference(_) | Role::Still => None,
        });
        Self {
            of_step,
            sweeps,
            by_fixed,
            of_point: point.inputs().map(role).collect(),
            step,
            point,
            constants: tape.differential(&[(Segment::Constants, Part::All)], &is_moving),
            coordinates,
            rotations: rotations.to_vec(),
            rows: unknowns,
            count,
            parameters,
        }
    }

    /// The values of the constants and the parameters of a system.
    pub fn fixed(&self, declaration: &Declaration<'_>, h: f64, rooms: &mut Rooms) -> Fixed {
        self.begin(declaration, h, rooms);
        let constants = (0..self.count).map(|k| self.constants.result(&rooms.constants, k).0[0]);
        let parameters = (0..self.parameters).map(|k| declaration.value(k));
        constants.chain(parameters).collect()
    }

    fn begin(&self, declaration: &Declaration<'_>, h: f64, rooms: &mut Rooms) {
        let value = |input| match input {
            Input::Leaf(Leaf::Parameter(place)) => Eight::splat(declaration.value(place)),
            _ => Eight::splat(h),
        };
        let source = declaration.source();
        self.constants
            .evaluate(source, &mut rooms.constants, 1, &mut { value });
    }

    /// The changes of constants and parameters that follow from changes of the parameters: up to eight of them, one in each lane.
    pub fn change_fixed(
        &self,
        declaration: &Declaration<'_>,
        h: f64,
        rooms: &mut Rooms,
        parameters: &dyn Fn(usize) -> Eight,
    ) -> Vec<Eight> {
        self.begin(declaration, h, rooms);
        let mut changes = vec![Eight::ZERO; self.count];
        let mut change = |input| match input {
            Input::Leaf(Leaf::Parameter(place)) => parameters(place),
            _ => Eight::ZERO,
        };
        self.constants
            .forward(&mut rooms.constants, &mut change, &mut |place, change| {
                changes[place] = change;
            });
        changes.extend((0..self.parameters).map(parameters));
        changes
    }

    /// The total derivatives by the parameters, from the partial ones by constants and parameters.
    pub fn of_parameters(
        &self,
        declaration: &Declaration<'_>,
        h: f64,
        rooms: &mut Rooms,
        of_fixed: &[f64],
    ) -> Vec<f64> {
        let (of_constants, of_parameters) = of_fixed.split_at(self.count);
        let mut sum = of_parameters.to_vec();
        if of_constants.iter().all(|x| *x == 0.0) {
            return sum;
        }
        self.begin(declaration, h, rooms);
        let inputs: Vec<Input> = self.constants.inputs().collect();
        let weight = |k: usize| Eight::splat(of_constants[k]);
        self.constants
            .back_from_all(&mut rooms.constants, &weight, &mut |input, slope| {
                if let Input::Leaf(Leaf::Parameter(place)) = inputs[input] {
                    sum[place] += slope.0[0];
                }
            });
        sum
    }

    /// Prepares the steps of a stretch.
    pub fn enter(&self, fixed: &[f64], h: f64, rooms: &mut Rooms) {
        for (differential, roles, room) in [
            (&self.step, &self.of_step, &mut rooms.step),
            (&self.point, &self.of_point, &mut rooms.point),
        ] {
            differential.make(room);
            for (place, role) in roles.iter().enumerate() {
                match role {
                    Role::Fixed(k) => differential.set(room, place, Eight::splat(fixed[*k])),
                    Role::Still => differential.set(room, place, Eight::splat(h)),
                    _ => {}
                }
            }
        }
    }

    /// Linearizes up to eight steps of the stretch that was entered.
    ///
    /// # Errors
    ///
    /// The index, among these steps, of the first one whose derivatives are not finite.
    pub fn linearize(&self, steps: &Steps<'_>, rooms: &mut Rooms, block: &mut Block) -> Result<(), usize> {
        set(&self.step, &self.of_step, steps, &mut rooms.step);
        if block.entries.is_empty() {
            let n = self.coordinates;
            let matrix = (self.rows + n) * (self.rows + 2 * n);
            block.entries.resize(matrix + self.by_fixed.len(), Eight::ZERO);
            block.slopes.resize(2 * n * n, Eight::ZERO);
        }
        let broken = dispatch::run_wide(Linearization {
            equations: self,
            steps,
            room: &mut rooms.step,
            block,
        });
        let mut lanes = broken.0.iter().take(steps.recorded.count());
        match lanes.position(|broken| *broken != 0.0) {
            Some(lane) => Err(lane),
            None => Ok(()),
        }
    }
}

/// The quaternions of the middle nodes of some steps.
#[inline(always)]
pub(super) fn quaternion(recorded: &StepSlice<'_>, first: usize) -> [Eight; SLOTS] {
    [0, 1, 2, 3].map(|k| recorded.gathered(StepSlice::node(first + k)))
}

impl Block {
    /// The derivatives of the second difference: for each component those by the node, then those by the increment.
    pub fn slopes(&self) -> &[Eight] {
        &self.slopes
    }

    /// The tangents of rotations on the legs to the last nodes.
    pub fn legs(&self) -> &Legs {
        &self.legs
    }

    /// The part of `δe` that comes from a change of constants and parameters.
    pub fn by_change(&mut self, equations: &Equations, change: &[f64], sum: &mut [Eight]) {
        dispatch::run_wide(ByChange {
            block: self,
            equations,
            change,
            sum,
        });
    }

    /// Adds the derivatives by constants and parameters that follow from those by the second difference.
    pub fn add_by_fixed(&mut self, equations: &Equations, by_e: &[Eight], sum: &mut [Eight]) {
        dispatch::run_wide(ByFixedOf {
            block: self,
            equations,
            by_e,
            sum,
        });
    }
}

/// The work of [`Block::by_change`].
struct ByChange<'a> {
    block: &'a mut Block,
    equations: &'a Equations,
    change: &'a [f64],
    sum: &'a mut [Eight],
}

impl Work for ByChange<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self {
            block,
            equations,
            change,
            sum,
        } = self;
        let rows = equations.rows;
        block.of_rows.clear();
        block.of_rows.resize(rows + equations.coordinates, Eight::ZERO);
        for &ByFixed { row, fixed, place } in &equations.by_fixed {
            let change = change[fixed];
            if change != 0.0 {
                block.of_rows[row] = block.of_rows[row] + block.entries[place] * Eight::splat(change);
            }
        }
        for (i, sum) in sum.iter_mut().enumerate() {
            *sum = block.of_rows[rows + i];
            for row in 0..rows {
                *sum = *sum - block.in_rows[i * rows + row] * block.of_rows[row];
            }
        }
    }
}

/// The work of [`Block::add_by_fixed`].
struct ByFixedOf<'a> {
    block: &'a mut Block,
    equations: &'a Equations,
    by_e: &'a [Eight],
    sum: &'a mut [Eight],
}

impl Work for ByFixedOf<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FUSED: bool>(self) {
        let Self {
            block,
            equations,
            by_e,
            sum,
        } = self;
        let rows = equations.rows;
        block.of_rows.clear();
        for row in 0..rows {
            let mut weight = Eight::ZERO;
            for (i, by_e) in by_e.iter().enumerate() {
                weight = weight - *by_e * block.in_rows[i * rows + row];
            }
            block.of_rows.push(weight);
        }
        block.of_rows.extend_from_slice(by_e);
        for &ByFixed { row, fixed, place } in &equations.by_fixed {
            sum[fixed] = sum[fixed] + block.of_rows[row] * block.entries[place];
        }
    }
}

/// The work of [`Equations::linearize`].
struct Linearization<'a> {
    equations: &'a Equations,
    steps: &'a Steps<'a>,
    room: &'a mut Workspace,
    block: &'a mut Block,
}

impl Work for Linearization<'_> {
    /// Not zero in the lanes whose step has derivatives that are not finite.
    type Output = Eight;

    #[inline(always)]
    fn run<const FUSED: bool>(self) -> Eight {
        let Self {
            equations,
            steps,
            room,
            block,
        } = self;
        let (rows, n) = (equations.rows, equations.coordinates);
        let width = rows + 2 * n;
        let Block {
            slopes,
            in_rows,
            entries: jacobian,
            right,
            legs,
            ..
        } = block;
        let count = steps.recorded.count();
        equations.step.sweep(
            &equations.sweeps,
            steps.declaration.source(),
            room,
            count,
            jacobian,
        );
        if !equations.rotations.is_empty() {
            let (recorded, rotations) = (&steps.recorded, &equations.rotations);
            let matrix = &mut jacobian[..(rows + n) * width];
            turning::by_turns(
                rotations,
                |first| quaternion(recorded, first),
                matrix,
                (width, rows),
            );
            let next = |i: usize| {
                recorded.gathered(recorded.increment(i)) + recorded.gathered(recorded.difference(i))
            };
            turning::legs(rotations, next, legs);
        }
        // weights of the rows: in_rows · ∂rows/∂z = ∂e/∂z
        in_rows.clear();
        match rows {
            1 => {
                let inverse = Eight::splat(1.0) / jacobian[0];
                in_rows.extend((0..n).map(|i| jacobian[(1 + i) * width] * inverse));
            }
            2 => {
                let [a, b, c, d] = [0, 1, width, width + 1].map(|place| jacobian[place]);
                let inverse = Eight::splat(1.0) / (a * d - b * c);
                for i in 0..n {
                    let (x, y) = (jacobian[(2 + i) * width], jacobian[(2 + i) * width + 1]);
                    in_rows.extend([(x * d - y * c) * inverse, (y * a - x * b) * inverse]);
                }
            }
            _ => {
                // the transposed Jacobian with `n` right-hand sides
                right.clear();
                for column in 0..rows {
                    right.extend((0..rows).map(|row| jacobian[row * width + column]));
                    right.extend((0..n).map(|i| jacobian[(rows + i) * width + column]));
                }
                solve(right, rows, n);
                for i in 0..n {
                    in_rows.extend((0..rows).map(|row| right[row * (rows + n) + rows + i]));
                }
            }
        }
        // zero if all components are finite: an infinite or NaN number times zero is NaN
        let mut broken = Eight::ZERO;
        for entry in in_rows.iter() {
            broken = broken + *entry * Eight::ZERO;
        }
        for (i, slopes) in slopes.chunks_exact_mut(2 * n).enumerate() {
            for (to, column) in slopes.iter_mut().zip(rows..) {
                let mut sum = jacobian[(rows + i) * width + column];
                for row in 0..rows {
                    sum = sum - in_rows[i * rows + row] * jacobian[row * width + column];
                }
                *to = sum;
                broken = broken + sum * Eight::ZERO;
            }
        }
        broken
    }
}

/// Solves eight systems of linear equations in place, each with its own pivots. A row has `size` coefficients and `sides` right-hand sides.
/// The scale of a row does not matter.
#[inline(always)]
fn solve(matrix: &mut [Eight], size: usize, sides: usize) {
    let width = size + sides;
    let one = Eight::splat(1.0);
    if size > 1 {
        for row in matrix.chunks_exact_mut(width) {
            let mut largest = Eight::ZERO;
            for x in &row[..size] {
                largest = largest.zip(*x, |largest, x| if x.abs() > largest { x.abs() } else { largest });
            }
            let scale = one / largest;
            for x in row.iter_mut() {
                *x = *x * scale;
            }
        }
    }
    for k in 0..size {
        if k + 1 < size {
            pivot(matrix, size, width, k);
        }
        let inverse = one / matrix[k * width + k];
        for column in k + 1..width {
            matrix[k * width + column] = matrix[k * width + column] * inverse;
        }
        for row in (0..size).filter(|&row| row != k) {
            let factor = matrix[row * width + k];
            for column in k + 1..width {
                matrix[row * width + column] =
                    matrix[row * width + column] - factor * matrix[k * width + column];
            }
        }
    }
}

/// Exchanges rows so that the largest entry of column `k` is in row `k`, in each lane.
#[inline(always)]
fn pivot(matrix: &mut [Eight], size: usize, width: usize, k: usize) {
    for other in k + 1..size {
        let (own, below) = (matrix[k * width + k], matrix[other * width + k]);
        let larger = own.zip(below, |own, below| f64::from(u8::from(below.abs() > own.abs())));
        if larger == Eight::ZERO {
            continue;
        }
        for column in k..width {
            let (own, below) = (matrix[k * width + column], matrix[other * width + column]);
            let select = |no: Eight, yes: Eight| {
                Eight::from_fn(|lane| {
                    if larger.0[lane] == 0.0 {
                        no.0[lane]
                    } else {
                        yes.0[lane]
                    }
                })
            };
            matrix[k * width + column] = select(own, below);
            matrix[other * width + column] = select(below, own);
        }
    }
}

/// Sets the inputs for up to eight steps. Unused lanes repeat the last step.
pub(super) fn set(differential: &Differential, roles: &[Role], steps: &Steps<'_>, room: &mut Workspace) {
    let recorded = &steps.recorded;
    for (place, (role, input)) in roles.iter().zip(differential.inputs()).enumerate() {
        let number = match (*role, input) {
            (Role::Node(i), _) => StepSlice::node(i),
            (Role::Increment(i), _) => recorded.increment(i),
            (Role::Difference(i), _) => recorded.difference(i),
            (Role::Unknown(i), _) => recorded.unknown(i),
            (Role::Still, Input::Leaf(Leaf::Clock)) => StepSlice::TIME,
            (Role::Fixed(_) | Role::Still, _) => continue,
        };
        differential.set(room, place, recorded.gathered(number));
    }
}
