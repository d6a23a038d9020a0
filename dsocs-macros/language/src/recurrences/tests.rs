//! The recurrences of some declarations: the number of products, and operations that must not occur.

#![allow(clippy::needless_pass_by_value)] // tokens are written in place

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::plan::Plan;
use super::sequence::Op;
use crate::emit::rust::jets::jets;
use crate::expand;

/// The numbers of products and squares of sequences in the recurrences of a declaration, and of rows that are
/// solved numerically.
fn counts(declaration: TokenStream, item: TokenStream) -> [usize; 3] {
    let model = match expand::model(declaration, &syn::parse2(item).unwrap()) {
        Ok(model) => model,
        Err(mistakes) => panic!("{mistakes:?}"),
    };
    let mut graph = model.graph.clone();
    let plan = Plan::of(&model, &mut graph);
    // squares may be placed in lanes of products
    let products = plan.sequences.products.iter();
    let among = products.filter(|[left, right]| left == right).count();
    [
        plan.sequences.products.len() - among,
        plan.sequences.squares.len() + among,
        plan.rows.len(),
    ]
}

fn particle() -> (TokenStream, TokenStream) {
    let declaration = quote! {
        coordinates(x, y);
        lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
        let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
        kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - curvature;
        variational = [(dot(x), dot(y))];
    };
    (
        declaration,
        quote!(
            struct Particle {
                mass: f64,
                curvature: f64,
            }
        ),
    )
}

fn pendulum() -> (TokenStream, TokenStream) {
    let declaration = quote! {
        coordinates(theta, psi);
        lagrangian = i / 2 * dot(theta).powi(2) + j / 2 * (dot(theta) + dot(psi)).powi(2) - m * (1 + theta.cos());
        let a = 1 / i;
        let b = -1 / i;
        let c = 1 / i + 1 / j;
        let g_c = d * (n * a - b) * (i * j);
        let h_c = d * (n * b - c) * (i * j);
        let f = (g_c.powi(2) + e) / h_c;
        let p1 = (i + j) * dot(theta) + j * dot(psi);
        let p2 = j * (dot(theta) + dot(psi));
        let w = g_c * p1 + h_c * p2;
        let lyapunov = f / 2 * p1.powi(2) + h_c / 2 * p2.powi(2) + g_c * p1 * p2
            + chi * (1 - (psi - n * theta).cos()) + m * e / d * (1 - theta.cos());
        kinematic = dot(lyapunov) + rho * w * w.tanh();
        constraint_forces = [(0, 1)];
        branch = divide(w);
    };
    let item = quote! {
        struct Pendulum { i: f64, j: f64, m: f64, d: f64, e: f64, chi: f64, n: f64, rho: f64 }
    };
    (declaration, item)
}

fn chain(n: usize) -> (TokenStream, TokenStream) {
    let n = Literal::usize_unsuffixed(n);
    let declaration = quote! {
        coordinates(theta: [#n]);
        let beyond = |i| sum(i..#n, |k| masses[k]);
        let cosine = |i, j| theta[i].cos() * theta[j].cos() + theta[i].sin() * theta[j].sin();
        let speed = |i| lengths[i] * dot(theta[i]);
        let kinetic = sum(0..#n, |i| {
            beyond(i) * (speed(i).powi(2) / 2 + sum(0..i, |j| cosine(i, j) * speed(i) * speed(j)))
        });
        let potential = -gravity * sum(0..#n, |i| beyond(i) * lengths[i] * theta[i].cos());
        lagrangian = kinetic - potential;
    };
    let item = quote!(struct Chain { masses: [f64; #n], lengths: [f64; #n], gravity: f64 });
    (declaration, item)
}

#[test]
fn the_particle_takes_two_products_and_three_squares() {
    // |v|³/|v|² is |v|: two squares of velocities, one for the root, and the curvature's rate times each
    // velocity
    let (declaration, item) = particle();
    assert_eq!(counts(declaration, item), [2, 3, 0]);
}

#[test]
fn the_pendulum_takes_five_products_and_a_square() {
    // sine and cosine of two angles, and the hyperbolic tangent
    let (declaration, item) = pendulum();
    assert_eq!(counts(declaration, item), [5, 1, 0]);
}

#[test]
fn products_of_a_top_are_all_known_before_its_orders() {
    let declaration = quote! {
        coordinates(r: rotation);
        let w = r.angular_velocity();
        let kinetic = sum(0..3, |i| moments[i] * w[i].powi(2)) / 2;
        lagrangian = kinetic - (r * arm)[2];
    };
    let item = quote!(
        struct Body {
            moments: [f64; 3],
            arm: [f64; 3],
        }
    );
    let model = expand::model(declaration.clone(), &syn::parse2(item.clone()).unwrap()).unwrap();
    assert_eq!(counts(declaration, item), [7, 2, 0]);
    // seven products in two blocks, and a block of squares
    assert_eq!(Plan::of(&model, &mut model.graph.clone()).whole, [2, 1]);
}

#[test]
fn the_factor_of_the_pendulum_is_divided_out_exactly() {
    let (declaration, item) = pendulum();
    let model = expand::model(declaration, &syn::parse2(item).unwrap()).unwrap();
    let mut graph = model.graph.clone();
    let plan = Plan::of(&model, &mut graph);
    let quotient = |op: &Op| matches!(op, Op::Quotient(..) | Op::Reciprocal(_));
    let ops: Vec<&Op> = plan.sequences.ops().map(|(_, op)| op).collect();
    assert!(!ops.iter().any(|op| quotient(op)), "{ops:?}");
    // the factor leaves its hyperbolic tangent in the dissipation
    assert!(ops.iter().any(|op| matches!(op, Op::Tanh(..))));
}

#[test]
fn a_chain_takes_nine_products_a_link() {
    for n in [3, 8, 20] {
        let (declaration, item) = chain(n);
        assert_eq!(counts(declaration, item), [8 * n, n, n]);
    }
}

#[test]
fn a_free_particle_takes_none() {
    let count = counts(
        quote! {
            coordinates(x);
            lagrangian = mass / 2 * dot(x).powi(2) - gravity * mass * x;
        },
        quote!(
            struct Free {
                mass: f64,
                gravity: f64,
            }
        ),
    );
    assert_eq!(count, [0, 0, 0]);
}

#[test]
fn products_with_the_parameters_are_none_of_sequences() {
    let count = counts(
        quote! {
            coordinates(x);
            lagrangian = mass / 2 * dot(x).powi(2) - stiffness / 2 * (x - length).powi(2);
        },
        quote!(
            struct Spring {
                mass: f64,
                stiffness: f64,
                length: f64,
            }
        ),
    );
    assert_eq!(count, [0, 0, 0]);
}

/// The names of a declaration's switches, as error messages show them; `None` if there are none.
fn switched(declaration: TokenStream, item: TokenStream) -> Option<String> {
    let model = match expand::model(declaration, &syn::parse2(item).unwrap()) {
        Ok(model) => model,
        Err(mistakes) => panic!("{mistakes:?}"),
    };
    let code = jets(&model).to_string();
    let (_, names) = code.split_once("const SWITCHES")?;
    let (_, names) = names.split_once("= & [")?;
    Some(names.split_once(']').unwrap().0.trim().to_owned())
}

#[test]
fn what_decides_between_pieces_is_named_and_what_does_not_costs_nothing() {
    let (declaration, item) = particle();
    assert_eq!(switched(declaration, item), None);
    let (declaration, item) = chain(3);
    assert_eq!(switched(declaration, item), None);
    // a steep function ends no motion
    let (declaration, item) = pendulum();
    assert_eq!(switched(declaration, item).unwrap(), "\"\"");
    // equal arguments are one switch, and arguments of the parameters are none
    let names = switched(
        quote! {
            coordinates(x);
            lagrangian = mass / 2 * dot(x).powi(2) - stiffness * ((x - length).abs() + (x - length).powi(2).sqrt());
            external_forces = (mass - 1).abs() * (2 * dot(x)).min(x.sin()) + push(x);
        },
        quote!(
            struct Friction {
                mass: f64,
                stiffness: f64,
                length: f64,
            }
        ),
    );
    assert_eq!(
        names.unwrap(),
        "\"2 * dot(x) - x.sin()\" , \"x - length\" , \"a comparison in push\""
    );
}
