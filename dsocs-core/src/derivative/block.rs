//! Up to eight steps of a path, linearized side by side.

use crate::system::Leg;
use crate::tape::{Differential, Eight, Input, Leaf, Part, Room, Segment, Source, Tape};

/// A step of a path: its first two nodes and the second difference.
#[derive(Clone, Copy, Debug)]
pub(super) struct Recorded<const N: usize> {
    /// The middle node and the increment that led to it.
    pub leg: Leg<f64, N>,
    /// The second difference that was found.
    pub e: [f64; N],
}

/// What an input of a differential is, for a step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Role {
    Node(usize),
    Increment(usize),
    Difference(usize),
    Unknown(usize),
    /// What the whole run has: a constant, or a parameter after these.
    Fixed(usize),
    /// What does not change: time, and the step.
    Still,
}

/// The differentials of the steps of a system.
#[derive(Clone, Debug)]
pub(super) struct Equations {
    /// The rows of a step, then the second difference.
    step: Differential,
    /// The point of a node.
    point: Differential,
    /// What is known when the run begins.
    constants: Differential,
    /// What the inputs of the first two are.
    of_step: Vec<Role>,
    of_point: Vec<Role>,
    /// How many rows there are.
    pub rows: usize,
    /// How many constants.
    count: usize,
    /// How many parameters.
    pub parameters: usize,
}

/// What is computed in.
#[derive(Clone, Debug, Default)]
pub(super) struct Rooms {
    step: Room,
    point: Room,
    constants: Room,
}

/// The values of the constants and of the parameters, on a stretch of the path.
pub(super) type Fixed = Vec<f64>;

/// Up to eight steps in a row with the same parameters.
pub(super) struct Steps<'p, const N: usize> {
    /// Where the functions of the user's are.
    pub source: &'p dyn Source,
    /// The values of what does not change.
    pub fixed: &'p [f64],
    /// The step.
    pub h: f64,
    /// The steps.
    pub recorded: &'p [Recorded<N>],
    /// Their unknowns, one step after the other.
    pub unknowns: &'p [f64],
}

/// A derivative of a row or of a second difference by what is fixed.
#[derive(Clone, Copy, Debug)]
struct ByFixed {
    row: usize,
    fixed: usize,
    slope: Eight,
}

/// The linearization of up to eight steps: `δe = by_node δq + by_increment δd + …`.
#[derive(Clone, Debug)]
pub(super) struct Block<const N: usize> {
    pub by_node: [[Eight; N]; N],
    pub by_increment: [[Eight; N]; N],
    /// How much of each row is in each component: `δe_i` loses `in_rows[i][r]` times the change of row `r`.
    in_rows: Vec<Eight>,
    /// Of rows, then of components.
    by_fixed: Vec<ByFixed>,
    /// For the elimination.
    jacobian: Vec<Eight>,
    right: Vec<Eight>,
}

impl Equations {
    pub fn new(tape: &Tape, parameters: usize) -> Self {
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
        Self {
            of_step: step.inputs().map(role).collect(),
            of_point: point.inputs().map(role).collect(),
            step,
            point,
            constants: tape.differential(&[(Segment::Constants, Part::All)], &is_moving),
            rows: tape.count(rows.0, rows.1),
            count,
            parameters,
        }
    }

    /// The values of the constants and the parameters of a system.
    pub fn fixed(&self, source: &dyn Source, h: f64, rooms: &mut Rooms) -> Fixed {
        self.begin(source, h, rooms);
        let constants = (0..self.count).map(|k| self.constants.result(&rooms.constants, k).0[0]);
        let parameters = (0..self.parameters).map(|k| source.value(k));
        constants.chain(parameters).collect()
    }

    fn begin(&self, source: &dyn Source, h: f64, rooms: &mut Rooms) {
        self.constants
            .evaluate(source, &mut rooms.constants, 1, &mut |input| match input {
                Input::Leaf(Leaf::Parameter(place)) => Eight::splat(source.value(place)),
                _ => Eight::splat(h),
            });
    }

    /// How the constants and the parameters change where the parameters do, in up to eight ways.
    pub fn change_fixed(
        &self,
        source: &dyn Source,
        h: f64,
        rooms: &mut Rooms,
        parameters: &dyn Fn(usize) -> Eight,
    ) -> Vec<Eight> {
        self.begin(source, h, rooms);
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

    /// The derivatives by the parameters, from those by the constants and the parameters.
    pub fn of_parameters(&self, source: &dyn Source, h: f64, rooms: &mut Rooms, of_fixed: &[f64]) -> Vec<f64> {
        let (of_constants, of_parameters) = of_fixed.split_at(self.count);
        let mut sum = of_parameters.to_vec();
        if of_constants.iter().all(|x| *x == 0.0) {
            return sum;
        }
        self.begin(source, h, rooms);
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

    /// Linearizes up to eight steps. Singular ones have what is not finite.
    pub fn linearize<const N: usize>(&self, steps: &Steps<'_, N>, rooms: &mut Rooms, block: &mut Block<N>) {
        let (rows, room) = (self.rows, &mut rooms.step);
        self.evaluate(&self.step, &self.of_step, steps, room);
        block.clear(rows);
        for row in 0..rows + N {
            let mut take = |input: usize, slope: Eight| {
                let by_unknown = match self.of_step[input] {
                    Role::Fixed(fixed) => return block.by_fixed.push(ByFixed { row, fixed, slope }),
                    Role::Unknown(place) => place,
                    Role::Node(place) => rows + place,
                    Role::Increment(place) => rows + N + place,
                    Role::Difference(_) | Role::Still => return,
                };
                block.jacobian[row * (rows + 2 * N) + by_unknown] = slope;
            };
            self.step.back_from(room, row, &mut take);
        }
        block.eliminate(rows);
    }

    /// Evaluates at the places of up to eight steps; what is beyond the last is the last once more.
    fn evaluate<const N: usize>(
        &self,
        differential: &Differential,
        roles: &[Role],
        steps: &Steps<'_, N>,
        room: &mut Room,
    ) {
        let Steps {
            source,
            fixed,
            h,
            recorded,
            unknowns,
        } = *steps;
        let last = recorded.len() - 1;
        let of = |value: &dyn Fn(&Recorded<N>) -> f64| Eight::from_fn(|lane| value(&recorded[lane.min(last)]));
        let mut place = 0;
        differential.evaluate(source, room, recorded.len(), &mut |input| {
            let role = roles[place];
            place += 1;
            match (role, input) {
                (Role::Node(i), _) => of(&|step| step.leg.q[i]),
                (Role::Increment(i), _) => of(&|step| step.leg.d[i]),
                (Role::Difference(i), _) => of(&|step| step.e[i]),
                (Role::Unknown(i), _) => {
                    Eight::from_fn(|lane| unknowns[lane.min(last) * self.rows + i])
                }
                (Role::Fixed(k), _) => Eight::splat(fixed[k]),
                (Role::Still, Input::Leaf(Leaf::Clock)) => of(&|step| step.leg.t),
                (Role::Still, _) => Eight::splat(h),
            }
        });
    }

    /// The points of up to eight nodes: positions, velocities, accelerations, times.
    pub fn points<const N: usize>(&self, steps: &Steps<'_, N>, rooms: &mut Rooms) -> ([[Eight; N]; 3], Eight) {
        self.evaluate(&self.point, &self.of_point, steps, &mut rooms.point);
        let result = |k: usize| self.point.result(&rooms.point, k);
        let point = core::array::from_fn(|part| core::array::from_fn(|i| result(part * N + i)));
        (point, result(3 * N))
    }

    /// How the points change that were evaluated last.
    pub fn change_points<const N: usize>(
        &self,
        rooms: &mut Rooms,
        change: &dyn Fn(Role) -> Eight,
    ) -> [[Eight; N]; 3] {
        let mut points = [[Eight::ZERO; N]; 3];
        let mut place = 0;
        let mut change = |_| {
            place += 1;
            change(self.of_point[place - 1])
        };
        self.point.forward(&mut rooms.point, &mut change, &mut |k, change| {
            if let Some(to) = points.as_flattened_mut().get_mut(k) {
                *to = change;
            }
        });
        points
    }

    /// The derivatives of a sum of components of the points that were evaluated last, each with its weight.
    pub fn back_from_points<const N: usize>(
        &self,
        rooms: &mut Rooms,
        weights: &[[Eight; N]; 3],
        take: &mut dyn FnMut(Role, Eight),
    ) {
        let weight = |k: usize| weights.as_flattened().get(k).copied().unwrap_or(Eight::ZERO);
        self.point
            .back_from_all(&mut rooms.point, &weight, &mut |input, slope| {
                take(self.of_point[input], slope);
            });
    }
}

impl<const N: usize> Block<N> {
    pub fn new() -> Self {
        Self {
            by_node: [[Eight::ZERO; N]; N],
            by_increment: [[Eight::ZERO; N]; N],
            in_rows: Vec::new(),
            by_fixed: Vec::new(),
            jacobian: Vec::new(),
            right: Vec::new(),
        }
    }

    fn clear(&mut self, rows: usize) {
        self.by_fixed.clear();
        self.jacobian.clear();
        self.jacobian.resize((rows + N) * (rows + 2 * N), Eight::ZERO);
    }

    /// From the derivatives of rows and components by unknowns, node and increment to those of the components alone.
    fn eliminate(&mut self, rows: usize) {
        let width = rows + 2 * N;
        // weights of the rows: in_rows · ∂rows/∂z = ∂e/∂z, by the transposed Jacobian with N right-hand sides
        self.right.clear();
        for column in 0..rows {
            self.right.extend((0..rows).map(|row| self.jacobian[row * width + column]));
            self.right.extend((0..N).map(|i| self.jacobian[(rows + i) * width + column]));
        }
        solve(&mut self.right, rows, N);
        self.in_rows.clear();
        for i in 0..N {
            self.in_rows
                .extend((0..rows).map(|row| self.right[row * (rows + N) + rows + i]));
        }
        for i in 0..N {
            for j in 0..N {
                for (to, column) in [
                    (&mut self.by_node[i][j], rows + j),
                    (&mut self.by_increment[i][j], rows + N + j),
                ] {
                    let mut sum = self.jacobian[(rows + i) * width + column];
                    for row in 0..rows {
                        sum = sum - self.in_rows[i * rows + row] * self.jacobian[row * width + column];
                    }
                    *to = sum;
                }
            }
        }
    }

    /// Whether the first lanes have a solution.
    pub fn is_finite(&self, lane: usize) -> bool {
        let entries = self.by_node.as_flattened().iter().chain(self.by_increment.as_flattened());
        entries.chain(&self.in_rows).all(|entry| entry.0[lane].is_finite())
    }

    /// What a change of constants and parameters adds to `δe`.
    pub fn by_change(&self, rows: usize, change: impl Fn(usize) -> f64) -> [Eight; N] {
        let mut of_rows = [Eight::ZERO; 64];
        let mut sum = [Eight::ZERO; N];
        for &ByFixed { row, fixed, slope } in &self.by_fixed {
            let term = slope * Eight::splat(change(fixed));
            match row.checked_sub(rows) {
                Some(component) => sum[component] = sum[component] + term,
                None if row < of_rows.len() => of_rows[row] = of_rows[row] + term,
                None => {
                    for (i, sum) in sum.iter_mut().enumerate() {
                        *sum = *sum - self.in_rows[i * rows + row] * term;
                    }
                }
            }
        }
        for (i, sum) in sum.iter_mut().enumerate() {
            for row in 0..rows.min(of_rows.len()) {
                *sum = *sum - self.in_rows[i * rows + row] * of_rows[row];
            }
        }
        sum
    }

    /// Adds the derivatives by constants and parameters, from those by the second difference.
    pub fn add_by_fixed(&self, rows: usize, by_e: &[Eight; N], sum: &mut [Eight]) {
        let mut of_rows = [Eight::ZERO; 64];
        let of_row = |row: usize| {
            let mut weight = Eight::ZERO;
            for (i, by_e) in by_e.iter().enumerate() {
                weight = weight - *by_e * self.in_rows[i * rows + row];
            }
            weight
        };
        for (row, weight) in of_rows.iter_mut().enumerate().take(rows) {
            *weight = of_row(row);
        }
        for &ByFixed { row, fixed, slope } in &self.by_fixed {
            let weight = match row.checked_sub(rows) {
                Some(component) => by_e[component],
                None if row < of_rows.len() => of_rows[row],
                None => of_row(row),
            };
            sum[fixed] = sum[fixed] + weight * slope;
        }
    }
}

/// Solves eight sets of linear equations in place: rows of `size` coefficients and `sides` right-hand sides, each set with its
/// own pivots. Rows may be of any size.
fn solve(matrix: &mut [Eight], size: usize, sides: usize) {
    let width = size + sides;
    if size > 1 {
        for row in matrix.chunks_exact_mut(width) {
            let largest = row[..size]
                .iter()
                .fold(Eight::ZERO, |largest, x| largest.zip(*x, |largest, x| largest.max(x.abs())));
            for x in row.iter_mut() {
                *x = *x / largest;
            }
        }
    }
    for k in 0..size {
        for lane in 0..Eight::COUNT {
            let entry = |row: usize| matrix[row * width + k].0[lane].abs();
            let pivot = (k + 1..size).fold(k, |best, row| if entry(row) > entry(best) { row } else { best });
            if pivot != k {
                for column in k..width {
                    let (own, other) = (matrix[k * width + column].0[lane], matrix[pivot * width + column].0[lane]);
                    matrix[k * width + column].0[lane] = other;
                    matrix[pivot * width + column].0[lane] = own;
                }
            }
        }
        let pivot = matrix[k * width + k];
        for column in k + 1..width {
            matrix[k * width + column] = matrix[k * width + column] / pivot;
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
