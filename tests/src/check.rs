//! Comparison of generated code with a [`Declaration`] written by hand, at one state.

use core::fmt::Display;

use dsocs_core::__private::{AnyLeg, Declaration as Tape, Tangent, Unknown as _};
use dsocs_core::{Leg, Point, Real, System};
use num_dual::Dual64;

use crate::independent::{self, Declaration};
use crate::tape;

/// The largest difference of two evaluations of one number, relative to the effect of rounding the nodes.
///
/// The independent rows are formed from nodes, whose rounding is a few units of `2.2e-16`; a mistake in a formula is of
/// the order of 1.
const ROUNDING: f64 = 1e-12;

/// The largest difference of a difference quotient (of fourth order) from the derivative.
const DIFFERENCE: f64 = 1e-6;

/// A state at which code is compared.
#[derive(Clone, Copy, Debug)]
pub struct State<const N: usize> {
    /// The step.
    pub h: f64,
    /// The middle node.
    pub q: [f64; N],
    /// The increment that led to it, over `h`: a velocity.
    pub v: [f64; N],
    /// The second difference, over `h²`: an acceleration.
    pub a: [f64; N],
}

/// Properties of a system on which a comparison depends.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Whether unknowns of Newton's iteration enter a user's function: then the generated code cannot be
    /// differentiated with [`Tangent`]s.
    pub opaque: bool,
    /// The step of difference quotients, relative to the unknown's natural scale `h² · 1`.
    pub nudge: f64,
}

impl Default for Kind {
    fn default() -> Self {
        Self {
            opaque: false,
            nudge: 1e-3,
        }
    }
}

/// The reason why a comparison failed.
#[derive(Clone, Debug, PartialEq)]
pub enum Mismatch {
    /// The declaration has no value at this state: nothing can be compared.
    Undefined,
    /// Two numbers differ; the text names them.
    Differs(String),
}

/// An error if two numbers differ by more than `tolerance`; NaN differs from every number.
fn expect(what: impl Display, generated: f64, independent: f64, tolerance: f64) -> Result<(), Mismatch> {
    if (generated - independent).abs() <= tolerance {
        return Ok(());
    }
    Err(Mismatch::Differs(format!(
        "{what}: generated {generated:e}, independent {independent:e}, tolerance {tolerance:e}"
    )))
}

/// Compares everything that `#[dsocs]` generates for one step and at one point.
///
/// # Errors
///
/// The first difference, in words.
pub fn compare<S: System<N>, P: Declaration<N>, const N: usize>(
    system: &S,
    declaration: &P,
    state: State<N>,
    kind: Kind,
) -> Result<(), Mismatch> {
    step(system, declaration, state, kind)?;
    point(system, declaration, state)
}

/// The rows, and their derivatives by each component of a vector, `[row][component]`. Compiled once, not for
/// every system, as is [`condition`].
fn differentiate(at: &[f64], function: &dyn Fn(&[Dual64]) -> Vec<Dual64>) -> (Vec<f64>, Vec<Vec<f64>>) {
    let mut moving: Vec<Dual64> = at.iter().map(|&x| Dual64::from(x)).collect();
    let columns: Vec<Vec<Dual64>> = (0..at.len())
        .map(|j| {
            moving[j].eps = 1.0;
            let column = function(&moving);
            moving[j].eps = 0.0;
            column
        })
        .collect();
    let rows = columns[0].iter().map(|row| row.re).collect();
    let jacobian = (0..columns[0].len())
        .map(|i| columns.iter().map(|column| column[i].eps).collect())
        .collect();
    (rows, jacobian)
}

/// The sum of `|derivative · x|`: the effect of a unit of relative error in `x`.
fn condition(slopes: &[f64], x: &[f64]) -> f64 {
    slopes.iter().zip(x).map(|(slope, x)| (slope * x).abs()).sum()
}

/// Whether all rows and derivatives are finite.
fn finite(rows: &[f64], slopes: &[Vec<f64>]) -> bool {
    rows.iter().chain(slopes.iter().flatten()).all(|x| x.is_finite())
}

/// A slice as an array.
fn sized<const N: usize>(x: &[Dual64]) -> [Dual64; N] {
    let mut vector = [Dual64::from(0.0); N];
    vector.copy_from_slice(x);
    vector
}

/// A vector times a number.
fn scaled<const N: usize>(x: &[f64; N], by: f64) -> [f64; N] {
    let mut scaled = *x;
    for x in &mut scaled {
        *x *= by;
    }
    scaled
}

/// The scalar product.
fn product(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

/// The sums of the absolute values of three vectors, component by component.
fn sizes([x, y, z]: [&[f64]; 3]) -> Vec<f64> {
    let sizes = x.iter().zip(y).zip(z);
    sizes.map(|((x, y), z)| x.abs() + y.abs() + z.abs()).collect()
}

/// The largest absolute value of a component.
fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |largest, x| x.abs().max(largest))
}

/// The sum of the absolute values of the components.
fn total(x: &[f64]) -> f64 {
    x.iter().map(|x| x.abs()).sum()
}

/// The nodes of a step.
fn nodes<R: Real, const N: usize>(q: [R; N], d: [R; N], e: [R; N]) -> [[R; N]; 3] {
    let q0 = core::array::from_fn(|i| q[i] - d[i]);
    let q2 = core::array::from_fn(|i| q[i] + (d[i] + e[i]));
    [q0, q, q2]
}

/// Compares the functions of a step.
fn step<S: System<N>, P: Declaration<N>, const N: usize>(
    system: &S,
    declaration: &P,
    State { h, q, v, a }: State<N>,
    kind: Kind,
) -> Result<(), Mismatch> {
    let leg = Leg {
        t: 0.0,
        q,
        d: scaled(&v, h),
    };
    let e = scaled(&scaled(&a, h), h);
    tape::same_bits(system, h, &leg, &e, &[]).map_err(Mismatch::Differs)?;
    let constants = system.constants(&system.parameters(), h);
    let known = system.known(&constants, &leg);
    let z = system.unknown(&e, &[]);
    let e = system.second_difference(&constants, &known, &z);
    let unknowns = z.as_ref().len();

    let dual = |x: [f64; N]| independent::fixed(x);
    let (rows, slopes) = differentiate(&e, &|e| {
        independent::rows(
            declaration,
            Dual64::from(h),
            nodes(dual(q), dual(leg.d), sized(e)),
        )
    });
    let (_, by_q) = differentiate(&q, &|q| {
        independent::rows(
            declaration,
            Dual64::from(h),
            nodes(sized(q), dual(leg.d), dual(e)),
        )
    });
    if !finite(&rows, &slopes) {
        return Err(Mismatch::Undefined);
    }
    // rounding q0 and q2 changes d and e, which enter with 1/h²
    let size = sizes([&q, &leg.d, &e]);
    let mut scale = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        scale.push(row.abs() + condition(&by_q[i], &q) + condition(&slopes[i], &size));
    }

    // rows: those that generated code has eliminated vanish at every z; the others are given with their
    // multipliers
    let generated = system.linearize(&constants, &known, &z);
    let scales = system.scales(&constants, &known, &z);
    let declared = generated.rows.zip(&scales, |row, scale| row / scale);
    let mut kept = Vec::new();
    for (i, (&row, &scale)) in rows.iter().zip(&scale).enumerate() {
        let next = declared.as_ref().get(kept.len());
        let eliminated = row.abs() <= ROUNDING * scale && rows.len() - unknowns > i - kept.len();
        match next {
            Some(&next) if (next - row).abs() <= ROUNDING * scale => kept.push(i),
            _ if eliminated => {}
            Some(&next) => expect(format_args!("row {i}"), next, row, ROUNDING * scale)?,
            None => expect(format_args!("eliminated row {i}"), 0.0, row, ROUNDING * scale)?,
        }
    }
    if kept.len() != unknowns {
        return Err(Mismatch::Differs(format!(
            "{unknowns} unknowns, but rows {kept:?} are left of {rows:?}"
        )));
    }

    // the Jacobian: by the chain rule through e(z), by the generated code, and by differences
    for k in 0..unknowns {
        let moved = moving(&Tape::of(system), h, leg.any(), z.as_ref(), k);
        for (place, &i) in kept.iter().enumerate() {
            let multiple = scales.as_ref()[place];
            let slope = generated.jacobian.as_ref()[place].as_ref()[k] / multiple;
            let entry = slope - declared.as_ref()[place] * (moved.scales[place] / multiple);
            let chain = product(&slopes[i], &moved.second_difference);
            let size = condition(&slopes[i], &moved.second_difference);
            // an entry's own condition is not known; that of its row over the unknown's scale is used
            let tolerance = 100.0 * ROUNDING * (size + entry.abs() + scale[i] / (h * h));
            expect(format_args!("∂row {i}/∂z{k}"), entry, chain, tolerance)?;
            if !kind.opaque {
                expect(
                    format_args!("∂row {i}/∂z{k} by itself"),
                    slope,
                    moved.rows[place] / multiple,
                    tolerance,
                )?;
            }
            let nudge = kind.nudge * h * h;
            let quotient = richardson(nudge, &|shift| {
                let mut z = z;
                z.as_mut()[k] += shift;
                system.linearize(&constants, &known, &z).rows.as_ref()[place] / multiple
            });
            let tolerance = DIFFERENCE * (size + slope.abs()) + 10.0 * f64::EPSILON * scale[i] / nudge;
            expect(
                format_args!("∂row {i}/∂z{k} by differences"),
                slope,
                quotient,
                tolerance,
            )?;
        }
    }

    reported(system, declaration, h, &leg, e)
}

/// Compares the report of a step with the second difference `e`.
fn reported<S: System<N>, P: Declaration<N>, const N: usize>(
    system: &S,
    declaration: &P,
    h: f64,
    leg: &Leg<f64, N>,
    e: [f64; N],
) -> Result<(), Mismatch> {
    let constants = system.constants(&system.parameters(), h);
    let known = system.known(&constants, leg);
    let step_report = system.report(&constants, &known, leg, &e);
    let (q, dual) = (leg.q, |x: [f64; N]| independent::fixed(x));
    let nodes = nodes(q, leg.d, e);
    let size = total(&sizes([&q, &leg.d, &e]));
    let at = step_report.point;
    let map = declaration.phi_kinematic(h, nodes);
    for (name, generated, independent, power) in [
        ("q", at.q, map[0], 0),
        ("v", at.v, map[1], 1),
        ("a", at.a, map[2], 2),
    ] {
        for i in 0..N {
            let tolerance = ROUNDING * (independent[i].abs() + size / h.abs().powi(power));
            expect(
                format_args!("{name}{i} of the point"),
                generated[i],
                independent[i],
                tolerance,
            )?;
        }
    }
    let force = step_report.force;
    let (expected, by_e) = differentiate(&e, &|e| {
        let nodes = self::nodes(dual(q), dual(leg.d), sized(e));
        independent::force(declaration, Dual64::from(h), nodes).to_vec()
    });
    for i in 0..N {
        let scale = expected[i].abs() + size * total(&by_e[i]);
        expect(
            format_args!("force {i}"),
            force[i],
            expected[i],
            ROUNDING * (scale + size),
        )?;
    }
    let expected = independent::discrete_lagrangian(declaration, h, nodes[0], q);
    let value = Tape::of(system).discrete_lagrangian(h, leg.any());
    let (_, by_node) = differentiate(&q, &|q| {
        vec![independent::discrete_lagrangian(
            declaration,
            Dual64::from(h),
            dual(nodes[0]),
            sized(q),
        )]
    });
    let scale = expected.abs() + 1.0 + size * total(&by_node[0]);
    expect("discrete Lagrangian", value, expected, ROUNDING * scale)
}

/// The derivatives of the declaration along unknown `k`, by [`Tangent`]s.
struct Moving {
    /// The derivatives of the rows.
    rows: Vec<f64>,
    /// The derivatives of the rows' multipliers.
    scales: Vec<f64>,
    /// The derivatives of the second difference.
    second_difference: Vec<f64>,
}

fn moving(tape: &Tape<'_>, h: f64, leg: AnyLeg<'_, f64>, z: &[f64], k: usize) -> Moving {
    let fixed = |x: &[f64]| -> Vec<Tangent> { x.iter().map(|&x| Tangent::new(x, 0.0)).collect() };
    let (q, d) = (fixed(leg.q), fixed(leg.d));
    let leg = AnyLeg {
        t: Tangent::new(leg.t, 0.0),
        q: &q,
        d: &d,
    };
    let h = Tangent::new(h, 0.0);
    let moving = z.iter().enumerate();
    let moving: Vec<_> = moving
        .map(|(j, &value)| Tangent::new(value, f64::from(u8::from(j == k))))
        .collect();
    let derivatives =
        |rows: Vec<Tangent>| -> Vec<f64> { rows.into_iter().map(Tangent::derivative).collect() };
    Moving {
        rows: derivatives(tape.rows(h, leg, &moving)),
        scales: derivatives(tape.scales(h, leg, &moving)),
        second_difference: derivatives(tape.second_difference(h, leg, &moving)),
    }
}

/// The derivative at 0 by central differences of two steps.
fn richardson(step: f64, function: &dyn Fn(f64) -> f64) -> f64 {
    let central = |step: f64| (function(step) - function(-step)) / (2.0 * step);
    (4.0 * central(step / 2.0) - central(step)) / 3.0
}

/// Adds those multiples of other rows to one that bring its slopes nearest to those of `to`; each row is its
/// value followed by its slopes. Returns the size of the sum of what was added.
fn add_multiples(row: &mut [f64], to: &[f64], others: Vec<Vec<f64>>) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a[1..].iter().zip(&b[1..]).map(|(a, b)| a * b).sum::<f64>();
    let add = |row: &mut [f64], other: &[f64], multiple: f64| {
        for (x, other) in row.iter_mut().zip(other) {
            *x += multiple * other;
        }
    };
    // each is orthogonalised against those before (Gram and Schmidt)
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut added = 0.0;
    for mut other in others {
        for before in &basis {
            let part = dot(&other, before) / dot(before, before);
            add(&mut other, before, -part);
        }
        let missing: Vec<f64> = to.iter().zip(&*row).map(|(to, x)| to - x).collect();
        let multiple = dot(&missing, &other) / dot(&other, &other);
        if multiple.is_finite() {
            added += multiple.abs() * other.iter().map(|x| x.abs()).sum::<f64>();
            add(row, &other, multiple);
            basis.push(other);
        }
    }
    added
}

/// Compares the functions at a point.
fn point<S: System<N>, P: Declaration<N>, const N: usize>(
    system: &S,
    declaration: &P,
    State { q, v, a, .. }: State<N>,
) -> Result<(), Mismatch> {
    let dual = |x: [f64; N]| independent::fixed(x);
    let (rows, by_a) = differentiate(&a, &|a| {
        independent::continuous_rows(declaration, dual(q), dual(v), sized(a))
    });
    let (_, by_q) = differentiate(&q, &|q| {
        independent::continuous_rows(declaration, sized(q), dual(v), dual(a))
    });
    let (_, by_v) = differentiate(&v, &|v| {
        independent::continuous_rows(declaration, dual(q), sized(v), dual(a))
    });
    if !finite(&rows, &by_a) {
        return Err(Mismatch::Undefined);
    }
    let tape = Tape::of(system);
    let generated = tape.continuous_with_jacobian(Point { t: 0.0, q, v, a }.any(), &[]);
    let (generated_rows, generated_slopes) = generated.split_at(N);
    // a factor may have been divided out together with the other rows: then multiples of these may be missing
    let divides = declaration.divide(q, v);
    let is_divided = |i: usize| divides.get(i).is_some_and(Option::is_some);
    let own = |k: usize| [&rows[k..=k], &by_a[k]].concat();
    let mut others = Vec::new();
    for k in 0..N {
        if !is_divided(k) {
            others.push(own(k));
        }
    }
    for i in 0..N {
        let mut generated = [&generated_rows[i..=i], &generated_slopes[i * N..][..N]].concat();
        let mut added = 0.0;
        if is_divided(i) {
            added = add_multiples(&mut generated, &own(i), others.clone());
        }
        let scale = rows[i].abs()
            + largest(&by_a[i])
            + condition(&by_a[i], &a)
            + condition(&by_q[i], &q)
            + condition(&by_v[i], &v)
            + added;
        expect(
            format_args!("continuous row {i}"),
            generated[0],
            rows[i],
            ROUNDING * scale,
        )?;
        for (j, (entry, slope)) in generated[1..].iter().zip(&by_a[i]).enumerate() {
            expect(
                format_args!("∂(continuous row {i})/∂a{j}"),
                *entry,
                *slope,
                ROUNDING * scale,
            )?;
        }
    }
    let (expected, by_v) = differentiate(&v, &|v| {
        independent::continuous_force(declaration, dual(q), sized(v), dual(a)).to_vec()
    });
    let (_, by_a) = differentiate(&a, &|a| {
        independent::continuous_force(declaration, dual(q), dual(v), sized(a)).to_vec()
    });
    let force = tape.continuous_force(Point { t: 0.0, q, v, a }.any());
    for i in 0..N {
        let scale = 1.0 + expected[i].abs() + condition(&by_v[i], &v) + condition(&by_a[i], &a);
        expect(
            format_args!("continuous force {i}"),
            force[i],
            expected[i],
            ROUNDING * scale,
        )?;
    }
    let (values, slopes) = differentiate(&v, &|v| vec![declaration.lagrangian(dual(q), sized(v))]);
    let scale = 1.0 + values[0].abs() + condition(&slopes[0], &v);
    expect(
        "Lagrangian",
        system.lagrangian(0.0, &q, &v),
        values[0],
        ROUNDING * scale,
    )?;
    let energy = independent::energy(declaration, q, v);
    expect(
        "energy",
        system.energy(0.0, &q, &v),
        energy,
        ROUNDING * (scale + energy.abs()),
    )
}
