//! The equations in numbers, against hand-written ones with numeric differences of the discrete Lagrangian.

use super::*;
use crate::expand;
use crate::graph::{Graph, Leaf, NodeId};
use crate::model::Model;

/// Data of a step with two coordinates, whose nodes are `N - D`, `N` and `N + D + E`.
const N: [f64; 2] = [0.7, -0.4];
const D: [f64; 2] = [0.23, 0.31];
const E: [f64; 2] = [-0.11, 0.07];

/// The step, the time of the middle node, and the multipliers.
const H: f64 = 0.3;
const CLOCK: f64 = 1.7;
const LAMBDA: [f64; 2] = [0.9, -1.3];

/// A state of the continuous system.
const V: [f64; 2] = [0.8, -0.6];
const A: [f64; 2] = [0.4, 1.9];

/// The only parameter.
const K: f64 = 2.5;

/// The largest error of central differences.
const DIFFERENCES: f64 = 1e-7;

type Node = (f64, [f64; 2]);

/// A time, a position and a velocity.
type Point = (f64, [f64; 2], [f64; 2]);

/// The points of a leg.
type Points = fn(Node, Node) -> Vec<Point>;

/// A force at a point.
type Acts<'f> = &'f dyn Fn(f64, [f64; 2], [f64; 2]) -> [f64; 2];

/// The discrete force at both nodes of a leg, `[f⁻_d, f⁺_d]`, for a given force.
type Shares = fn(Node, Node, Acts<'_>) -> [[f64; 2]; 2];

/// A discrete Lagrangian.
type OnLeg<'f> = &'f dyn Fn(Node, Node) -> f64;

fn node(k: i32) -> Node {
    let q = match k {
        0 => [N[0] - D[0], N[1] - D[1]],
        1 => N,
        _ => [N[0] + D[0] + E[0], N[1] + D[1] + E[1]],
    };
    (CLOCK + f64::from(k - 1) * H, q)
}

fn model(statements: &str) -> Model {
    let declaration = format!("coordinates(x, y); {statements}").parse().unwrap();
    match expand::model(declaration, &syn::parse_str("struct S { k: f64 }").unwrap()) {
        Ok(model) => model,
        Err(mistakes) => panic!("{statements}\n{:?}", mistakes.errors),
    }
}

fn values(graph: &Graph, nodes: &[NodeId]) -> Vec<f64> {
    let leaf = |leaf: Leaf| match leaf {
        Leaf::N(i) | Leaf::Q(i) => N[i],
        Leaf::D(i) => D[i],
        Leaf::E(i) => E[i],
        Leaf::V(i) => V[i],
        Leaf::A(i) => A[i],
        Leaf::Lambda(j) => LAMBDA[j],
        Leaf::H => H,
        Leaf::Clock | Leaf::T => CLOCK,
        other => panic!("{other:?} is left"),
    };
    graph.values(nodes, &leaf, &|_| K).unwrap()
}

#[track_caller]
fn near(found: f64, wanted: f64, tolerance: f64) {
    assert!(
        (found - wanted).abs() <= tolerance * (1.0 + wanted.abs()),
        "{found}, not {wanted}"
    );
}

/// The derivative of a function by a component of a vector.
fn slope(at: [f64; 2], i: usize, function: impl Fn([f64; 2]) -> f64) -> f64 {
    let moved = |by: f64| {
        let mut x = at;
        x[i] += by;
        function(x)
    };
    (moved(1e-5) - moved(-1e-5)) / 2e-5
}

/// A declaration by hand: `L(t, q, v)`, the external forces, and the points of a leg that are averaged.
struct ByHand {
    lagrangian: fn(f64, [f64; 2], [f64; 2]) -> f64,
    forces: fn(f64, [f64; 2], [f64; 2]) -> [f64; 2],
    points: Points,
    /// The shares of the external forces at the nodes, `f⁻_d` and `f⁺_d`.
    shares: Shares,
}

fn chord((_, a): Node, (_, b): Node) -> [f64; 2] {
    [(b[0] - a[0]) / H, (b[1] - a[1]) / H]
}

fn middle((s, a): Node, (t, b): Node) -> (f64, [f64; 2]) {
    (
        f64::midpoint(s, t),
        [f64::midpoint(a[0], b[0]), f64::midpoint(a[1], b[1])],
    )
}

fn half(f: [f64; 2]) -> [f64; 2] {
    f.map(|f| f / 2.0)
}

/// Half of the force at each end, with the chord's velocity.
fn ends(a: Node, b: Node, f: Acts<'_>) -> [[f64; 2]; 2] {
    let v = chord(a, b);
    [half(f(a.0, a.1, v)), half(f(b.0, b.1, v))]
}

/// The statements for [`lagrangian`] and [`forces`].
const BODY: &str =
    "lagrangian = (1 + x.sin() / 2) * dot(x).powi(2) / 2 + k * dot(y).powi(2) / 2 + x * dot(y) * t
        - x * y.powi(2) * (1 + t.sin());
    external_forces = (-dot(x) * y, t * x - dot(y).powi(3));";

fn lagrangian(t: f64, [x, y]: [f64; 2], [u, v]: [f64; 2]) -> f64 {
    (1.0 + x.sin() / 2.0) * u * u / 2.0 + K * v * v / 2.0 + x * v * t - x * y * y * (1.0 + t.sin())
}

fn forces(t: f64, [x, y]: [f64; 2], [u, v]: [f64; 2]) -> [f64; 2] {
    [-u * y, t * x - v.powi(3)]
}

impl ByHand {
    fn new(points: Points, shares: Shares) -> Self {
        Self {
            lagrangian,
            forces,
            points,
            shares,
        }
    }

    fn discrete_lagrangian(&self, a: Node, b: Node) -> f64 {
        let points = (self.points)(a, b);
        let values = points.iter().map(|&(t, q, v)| (self.lagrangian)(t, q, v));
        values.sum::<f64>() / points.len() as f64
    }

    /// `-(D₁L_d(q1, q2) + D₂L_d(q0, q1) + f⁻_d(q1, q2) + f⁺_d(q0, q1))`.
    fn force(&self) -> [f64; 2] {
        let [first, (t, q), last] = [0, 1, 2].map(node);
        let f = |t, q, v| (self.forces)(t, q, v);
        let external = [
            (self.shares)((t, q), last, &f)[0],
            (self.shares)(first, (t, q), &f)[1],
        ];
        [0, 1].map(|i| {
            let action = |q| self.discrete_lagrangian(first, (t, q)) + self.discrete_lagrangian((t, q), last);
            -slope(q, i, action) - external[0][i] - external[1][i]
        })
    }

    #[track_caller]
    fn is(&self, statements: &str) {
        let model = model(&format!("{BODY} {statements}"));
        let mut graph = model.graph.clone();
        let step = step(&model, &mut graph);
        let force = values(&graph, &step.force);
        let by_subtraction: Vec<NodeId> = step.rows.iter().map(|row| row.by_subtraction).collect();
        let rows: Vec<NodeId> = step.rows.iter().map(|row| row.value).collect();
        for (i, wanted) in self.force().into_iter().enumerate() {
            near(force[i], wanted, DIFFERENCES);
            // without constraints the rows are the components of the force
            near(values(&graph, &rows)[i], force[i], 1e-14);
            near(values(&graph, &by_subtraction)[i], force[i], 1e-12);
        }
        let on_leg = discrete_lagrangian(&model, &mut graph);
        near(
            values(&graph, &[on_leg])[0],
            self.discrete_lagrangian(node(0), node(1)),
            1e-14,
        );
        if let Some(found) = external_on_leg(&model, &mut graph) {
            let found = found.map(|parts| on_first_leg(&model, &mut graph, &parts));
            let wanted = (self.shares)(node(0), node(1), &|t, q, v| (self.forces)(t, q, v));
            for (found, wanted) in found.iter().zip(wanted) {
                let found = values(&graph, found);
                near(found[0], wanted[0], 1e-13);
                near(found[1], wanted[1], 1e-13);
            }
        }
    }
}

#[test]
fn the_force_is_that_of_the_declared_map() {
    ByHand::new(|a, b| vec![(a.0, a.1, chord(a, b))], ends).is("phi_lagrangian = paper;");
    let at_the_middle = |a: Node, b: Node, f: Acts<'_>| {
        let (t, q) = middle(a, b);
        [half(f(t, q, chord(a, b))); 2]
    };
    let point = |a, b| {
        let (t, q) = middle(a, b);
        vec![(t, q, chord(a, b))]
    };
    // the default map, if the mass matrix depends on the position
    ByHand::new(point, at_the_middle).is("");
    ByHand::new(point, at_the_middle).is("phi_lagrangian = midpoint;");
    let trapezoid = |a: Node, b: Node| vec![(a.0, a.1, chord(a, b)), (b.0, b.1, chord(a, b))];
    ByHand::new(trapezoid, ends).is("phi_lagrangian = trapezoid;");
}

/// A map to the first node's position at another time: forces act there, not at both ends of the leg.
#[test]
fn a_point_with_the_time_of_another_is_not_the_papers() {
    ByHand::new(
        |a, b| vec![(b.0, a.1, chord(a, b))],
        |a, b, f| [f(b.0, a.1, chord(a, b)), [0.0; 2]],
    )
    .is("phi_lagrangian = |t0, q0, t1, q1| (t1, q0, (q1 - q0) / h);");
}

/// A velocity that is no function of the difference of the nodes, so that nothing cancels.
#[test]
fn the_velocity_of_a_map_may_depend_on_the_nodes() {
    fn velocity(a: Node, b: Node) -> [f64; 2] {
        let [u, v] = chord(a, b);
        [u * (1.0 + a.1[0] / 2.0), v + a.1[1] * b.1[0]]
    }
    fn place(a: Node, b: Node) -> [f64; 2] {
        [0, 1].map(|i| a.1[i] * 0.75 + b.1[i] * 0.25)
    }
    ByHand::new(
        |a, b| vec![(a.0 + H / 2.0, place(a, b), velocity(a, b))],
        |a, b, f| {
            let f = f(a.0 + H / 2.0, place(a, b), velocity(a, b));
            [f.map(|f| 0.75 * f), f.map(|f| 0.25 * f)]
        },
    )
    .is("phi_lagrangian = |q0, q1| (
        (3 * q0 + q1) / 4,
        ((q1.x - q0.x) / h * (1 + q0.x / 2), (q1.y - q0.y) / h + q0.y * q1.x),
    );");
}

/// A declared discrete Lagrangian does not depend on the difference of the nodes alone.
#[test]
fn a_discrete_lagrangian_may_be_given() {
    let model = model(
        "lagrangian = dot(x).powi(2) / 2 + dot(y).powi(2) / 2;
         discrete_lagrangian = (x[1] - x[0]).powi(2) / h.powi(2) * (2 + x[0]) + y[0] * y[1].powi(2) + x[0] * y[1] * h;",
    );
    let by_hand = |(_, a): Node, (_, b): Node| {
        (b[0] - a[0]).powi(2) / (H * H) * (2.0 + a[0]) + a[1] * b[1] * b[1] + a[0] * b[1] * H
    };
    let mut graph = model.graph.clone();
    let step = step(&model, &mut graph);
    let [first, (t, q), last] = [0, 1, 2].map(node);
    for (i, row) in step.rows.iter().enumerate() {
        let wanted = -slope(q, i, |q| by_hand(first, (t, q)) + by_hand((t, q), last));
        let found = values(&graph, &[step.force[i], row.value, row.by_subtraction]);
        near(found[0], wanted, DIFFERENCES);
        near(found[1], wanted, DIFFERENCES);
        near(found[2], wanted, DIFFERENCES);
    }
    let momentum = momentum_at_second_node(&model, &mut graph);
    for (i, found) in values(&graph, &momentum).into_iter().enumerate() {
        near(found, slope(N, i, |q| by_hand(first, (t, q))), DIFFERENCES);
    }
}

/// The momentum at the second node of a leg: with the paper's map, that of the trapezoid.
#[test]
fn momenta_at_the_second_node() {
    let middle_of = |a, b| {
        let (t, q) = middle(a, b);
        lagrangian(t, q, chord(a, b))
    };
    let mean = |a: Node, b: Node| {
        f64::midpoint(
            lagrangian(a.0, a.1, chord(a, b)),
            lagrangian(b.0, b.1, chord(a, b)),
        )
    };
    let (first, second) = (node(0), node(1));
    let cases: [(&str, OnLeg<'_>, f64); 3] = [
        ("paper", &mean, 1.0),
        ("trapezoid", &mean, 1.0),
        ("midpoint", &middle_of, 0.5),
    ];
    for (map, discrete, place) in cases {
        let model = model(&format!("{BODY} phi_lagrangian = {map};"));
        let mut graph = model.graph.clone();
        let momentum = momentum_at_second_node(&model, &mut graph);
        let t = first.0 + place * H;
        let q = [0, 1].map(|i| first.1[i] + place * D[i]);
        let external = forces(t, q, chord(first, second));
        for (i, found) in values(&graph, &momentum).into_iter().enumerate() {
            let wanted = slope(N, i, |q| discrete(first, (second.0, q)));
            near(found, wanted + external[i] / 2.0, DIFFERENCES);
        }
    }
}

fn rows_of(graph: &Graph, rows: &[Equation]) -> Vec<[f64; 2]> {
    let of = |row: &Equation| {
        let both = values(graph, &[row.value, row.by_subtraction]);
        [both[0], both[1]]
    };
    rows.iter().map(of).collect()
}

/// Constraints of all orders at their places: at the last node (plus a small part of the rounding error at
/// the middle one), on the last leg, at the triple.
#[test]
fn constraints_stand_where_their_order_says() {
    let g = |(t, [x, y]): Node| x * x + y.sin() * t;
    let c = |t: f64, [x, y]: [f64; 2], [u, v]: [f64; 2]| y * u - x * v + t * x;
    let body = "lagrangian = dot(x).powi(2) / 2 + dot(y).powi(2) / 2; holonomic = x.powi(2) + y.sin() * t;";
    let alone = model(body);
    let mut graph = alone.graph.clone();
    let step_of = step(&alone, &mut graph);
    let found = rows_of(&graph, &step_of.rows)[0];
    let wanted = g(node(2)) - g(node(1)) * (1.0 - 1.0 / 1024.0);
    near(found[0], wanted, 1e-14);
    near(found[1], wanted, 1e-14);

    for (map, points) in [
        ("midpoint", vec![0.5]),
        ("trapezoid", vec![0.0, 1.0]),
        ("paper", vec![0.0]),
    ] {
        let both = model(&format!(
            "{body} nonholonomic = y * dot(x) - x * dot(y) + t * x; phi_lagrangian = {map};"
        ));
        let mut graph = both.graph.clone();
        let step_of = step(&both, &mut graph);
        assert_eq!((step_of.rows.len(), step_of.multipliers), (4, 2));
        let on = |from: i32| {
            let (a, b) = (node(from), node(from + 1));
            let value = |place: f64| {
                let q = [0, 1].map(|i| a.1[i] + place * (b.1[i] - a.1[i]));
                c(a.0 + place * H, q, chord(a, b))
            };
            points.iter().map(|&place| value(place)).sum::<f64>() / points.len() as f64
        };
        let found = rows_of(&graph, &step_of.rows);
        near(found[1][0], on(1), 1e-13);
        near(found[1][1], on(1), 1e-13);
        // Q − λ₁ dg(q1) − λ₂ ∂c/∂v at the triple's point
        let force = values(&graph, &step_of.force);
        let (t, [x, y]) = node(1);
        let form = [[2.0 * x, y.cos() * t], [y, -x]];
        for i in 0..2 {
            let wanted = force[i] - LAMBDA[0] * form[0][i] - LAMBDA[1] * form[1][i];
            near(found[2 + i][0], wanted, 1e-13);
            near(found[2 + i][1], wanted, 1e-12);
        }
        // on the leg before, and at a state
        let pairs = pair(&both, &mut graph);
        let pairs = values(&graph, &pairs);
        near(pairs[0], g(node(1)), 1e-14);
        near(pairs[1], on(0), 1e-13);
        let state = phase(&both, &mut graph);
        let state = values(&graph, &state);
        assert_eq!(state.len(), 3);
        near(state[0], g(node(1)), 1e-14);
        near(state[1], c(CLOCK, N, V), 1e-14);
        near(state[2], 2.0 * x * V[0] + y.cos() * t * V[1] + y.sin(), 1e-14);
    }
}

/// A row of second order at the paper's point, and at another one, with the work along the fields.
#[test]
fn a_row_of_second_order_and_the_works() {
    let row = |[x, y]: [f64; 2], [u, v]: [f64; 2], [a, b]: [f64; 2]| x * b - y * a + u * v * K;
    let body = format!(
        "{BODY} kinematic = x * ddot(y) - y * ddot(x) + dot(x) * dot(y) * k; variational = [(dot(x), x * dot(y))]; phi_lagrangian = midpoint;"
    );
    let [(_, q0), (_, q1), (_, q2)] = [0, 1, 2].map(node);
    let v = [0, 1].map(|i| (q2[i] - q0[i]) / (2.0 * H));
    let a = [0, 1].map(|i| (q2[i] - 2.0 * q1[i] + q0[i]) / (H * H));
    for (map, [q, v, a]) in [
        ("", [q1, v, a]),
        (
            "phi_kinematic = |q0, q1, q2| ((q0 + q2) / 2, (q1 - q0) / h, (q2 - q1) / h);",
            [
                [0, 1].map(|i| f64::midpoint(q0[i], q2[i])),
                [0, 1].map(|i| (q1[i] - q0[i]) / H),
                [0, 1].map(|i| (q2[i] - q1[i]) / H),
            ],
        ),
    ] {
        let model = model(&format!("{body} {map}"));
        let mut graph = model.graph.clone();
        let step_of = step(&model, &mut graph);
        let found = rows_of(&graph, &step_of.rows);
        near(found[0][0], row(q, v, a), 1e-12);
        let force = values(&graph, &step_of.force);
        let work = v[0] * force[0] + q[0] * v[1] * force[1];
        near(found[1][0], work, 1e-12);
        near(found[1][1], work, 1e-11);
    }
}

/// The continuous system: `d/dt ∂L/∂v - ∂L/∂q - f`, its rows differentiated until they contain accelerations,
/// and its energy.
#[test]
fn the_continuous_system() {
    let model = model(&format!("{BODY} holonomic = x.powi(2) + y.sin() * t;"));
    let mut graph = model.graph.clone();
    let continuous = continuous(&model, &mut graph);
    let force = values(&graph, &continuous.force);
    assert_eq!(force.len(), 2);
    let momentum = |t: f64, q: [f64; 2], v: [f64; 2], i: usize| slope(v, i, |v| lagrangian(t, q, v));
    for (i, found) in force.into_iter().enumerate() {
        let at = |s: f64| {
            let q = [0, 1].map(|j| N[j] + s * V[j]);
            momentum(CLOCK + s, q, [0, 1].map(|j| V[j] + s * A[j]), i)
        };
        let rate = (at(1e-4) - at(-1e-4)) / 2e-4;
        let wanted = rate - slope(N, i, |q| lagrangian(CLOCK, q, V)) - forces(CLOCK, N, V)[i];
        near(found, wanted, 1e-5);
    }
    let g = |s: f64| {
        let [x, y] = [0, 1].map(|j| N[j] + s * V[j] + s * s / 2.0 * A[j]);
        x * x + y.sin() * (CLOCK + s)
    };
    let second = (g(1e-3) - 2.0 * g(0.0) + g(-1e-3)) / 1e-6;
    near(values(&graph, &[continuous.rows[0].value])[0], second, 1e-5);
    let energy = energy(&model, &mut graph);
    let momenta = [0, 1].map(|i| momentum(CLOCK, N, V, i));
    let wanted = momenta[0] * V[0] + momenta[1] * V[1] - lagrangian(CLOCK, N, V);
    near(values(&graph, &[energy])[0], wanted, DIFFERENCES);
}

/// A declared factor is evaluated at the point of its row.
#[test]
fn a_factor_stands_at_the_point_of_its_row() {
    let model = model(
        "lagrangian = dot(x).powi(2) / 2 + dot(y).powi(2) / 2; let w = dot(x) + y;
         kinematic = w * (ddot(x) + x); constraint_forces = [(1, 0)]; branch = divide(w);",
    );
    let mut graph = model.graph.clone();
    let step_of = step(&model, &mut graph);
    let factor = step_of.rows[0].divide.unwrap();
    let [(_, q0), (_, q1), (_, q2)] = [0, 1, 2].map(node);
    near(
        values(&graph, &[factor])[0],
        (q2[0] - q0[0]) / (2.0 * H) + q1[1],
        1e-14,
    );
}

/// Which steps can be composed, and the first reason why one cannot.
#[test]
fn symmetry_in_time() {
    let free = "lagrangian = dot(x).powi(2) / 2 + dot(y).powi(2) / 2";
    let curved = "lagrangian = (1 + x.powi(2)) * dot(x).powi(2) / 2 + dot(y).powi(2) / 2";
    let servo = "kinematic = ddot(x) + dot(x) + y; constraint_forces = [(1, 0)];";
    for (statements, wanted) in [
        (format!("{free} - x * y;"), Symmetry::AnyLegs),
        (format!("{free} - x * y; {servo}"), Symmetry::AnyLegs),
        (format!("{free}; holonomic = x - y.sin();"), Symmetry::LowerOrder),
        (format!("{curved}; phi_lagrangian = paper;"), Symmetry::Momenta),
        (format!("{curved};"), Symmetry::Momenta),
        (
            format!("{curved}; phi_lagrangian = |q0, q1| ((3 * q0 + q1) / 4, (q1 - q0) / h);"),
            Symmetry::LagrangianMap,
        ),
        (
            format!("{free}; external_forces = (-dot(x).powi(3), 0);"),
            Symmetry::Momenta,
        ),
        (
            format!(
                "{free}; {servo} phi_kinematic = |q0, q1, q2| (q0, (q2 - q0) / (2 * h), (q2 - 2 * q1 + q0) / h.powi(2));"
            ),
            Symmetry::KinematicMap,
        ),
        (
            format!(
                "{free}; kinematic = ddot(x) + dot(x) + y; variational = [(dot(x), 1 + x)];
                phi_variational = |q0, q1, q2| (q0, (q2 - q0) / (2 * h), (q2 - 2 * q1 + q0) / h.powi(2));"
            ),
            Symmetry::VariationalMap,
        ),
    ] {
        let model = model(&statements);
        let mut graph = model.graph.clone();
        let step = step(&model, &mut graph);
        assert_eq!(Symmetry::decide(&model, &graph, &step), wanted, "{statements}");
    }
}
