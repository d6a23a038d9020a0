//! The generated code of some declarations: snapshots, and operations that must not occur.

#![allow(clippy::needless_pass_by_value)] // tokens are written in place

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use crate::expand::expand;

/// The code, without the bytes of the tape and the text of the declaration.
fn code(declaration: TokenStream, item: TokenStream) -> String {
    without_tape(&with_tape(declaration, item))
}

fn with_tape(declaration: TokenStream, item: TokenStream) -> String {
    let expanded = expand(declaration, &item);
    match syn::parse2::<syn::File>(expanded.clone()) {
        Ok(mut file) => {
            // jets have tests of their own
            file.items.retain(|item| !is_jets(item));
            without_declaration(&prettyplease::unparse(&file))
        }
        Err(error) => panic!("not Rust: {error}\n{expanded}"),
    }
}

/// The code without the text of the declaration.
fn without_declaration(code: &str) -> String {
    let Some(start) = code.find("    const DECLARATION") else {
        return code.to_owned();
    };
    let end = code[start..]
        .find("\";\n")
        .map_or(code.len(), |end| start + end + 3);
    format!("{}{}", &code[..start], &code[end..])
}

/// The code with the tape's length in place of its bytes, whose operations are those of the code.
fn without_tape(code: &str) -> String {
    let (Some(start), Some(end)) = (code.find("b\""), code.find("\",\n        );")) else {
        return code.to_owned();
    };
    format!("{}/* the tape */{}", &code[..start], &code[end + 1..])
}

/// Whether an item implements Taylor series.
fn is_jets(item: &syn::Item) -> bool {
    let syn::Item::Impl(item) = item else {
        return false;
    };
    let path = item.trait_.as_ref().and_then(|(path, _)| path.segments.last());
    path.is_some_and(|segment| segment.ident == "Jets")
}

/// The body of one generated method.
fn method(code: &str, name: &str) -> String {
    let start = code
        .find(&format!("    fn {name}<"))
        .unwrap_or_else(|| panic!("no method {name}"));
    let rest = &code[start..];
    rest[..rest.find("\n    }\n").unwrap_or(rest.len())].to_owned()
}

fn particle(extra: TokenStream) -> String {
    without_tape(&particle_with_tape(extra))
}

fn particle_with_tape(extra: TokenStream) -> String {
    with_tape(
        quote! {
            coordinates(x, y);
            lagrangian = mass / 2 * (dot(x).powi(2) + dot(y).powi(2));
            let speed = (dot(x).powi(2) + dot(y).powi(2)).sqrt();
            kinematic = (dot(x) * ddot(y) - ddot(x) * dot(y)) / speed.powi(3) - curvature.at(x, y);
            variational = [(dot(x), dot(y))];
            #extra
        },
        quote! {
            /// A particle.
            pub struct CurvedParticle<K: Curvature> {
                /// Mass [kg]
                pub mass: f64,
                pub curvature: K,
            }
        },
    )
}

#[test]
fn particle_with_prescribed_curvature() {
    insta::assert_snapshot!(particle(quote!()));
}

/// The inertia wheel pendulum.
fn pendulum() -> String {
    code(
        quote! {
            coordinates(theta, psi);
            lagrangian = i / 2 * dot(theta).powi(2) + j / 2 * (dot(theta) + dot(psi)).powi(2) - m * (1 + theta.cos());
            let a = 1 / i;
            let b = -1 / i;
            let c = 1 / i + 1 / j;
            let det = a * c - b * b;
            let gc = d * (n * a - b) / det;
            let hc = d * (n * b - c) / det;
            let f = (gc.powi(2) + e) / hc;
            let p1 = (i + j) * dot(theta) + j * dot(psi);
            let p2 = j * (dot(theta) + dot(psi));
            let w = gc * p1 + hc * p2;
            let lyapunov = f / 2 * p1.powi(2) + hc / 2 * p2.powi(2) + gc * p1 * p2
                + chi * (1 - (psi - n * theta).cos())
                + m * e / d * (1 - theta.cos());
            kinematic = dot(lyapunov) + rho * w.tanh() * w;
            constraint_forces = [(0, 1)];
            branch = divide(w);
            observe = [lyapunov];
        },
        quote! {
            pub struct Pendulum {
                i: f64, j: f64, m: f64, d: f64, e: f64, chi: f64, n: f64, rho: f64,
            }
        },
    )
}

#[test]
fn pendulum_with_a_lyapunov_constraint() {
    let code = pendulum();
    assert!(
        code.contains("type Unknown<__T: ::dsocs_core::__private::Scalar> = [__T; 1];"),
        "the linear row is solved for psi"
    );
    // the factor w divides the constraint exactly, so there is no division left
    let rows = method(&code, "linearize");
    assert!(!rows.contains("recip") && !rows.contains(" / "), "{rows}");
    insta::assert_snapshot!(code);
}

/// The book's listing is the generated code.
#[test]
fn the_book_shows_the_pendulums_step() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../dsocs-systems/src/guide/performance.md"
    );
    let book = std::fs::read_to_string(path).expect("the chapter");
    let code = pendulum();
    for (name, arguments) in [
        ("known", "constants, leg"),
        ("linearize", "constants, known, z"),
        ("second_difference", "constants, known, z"),
    ] {
        let method = method(&code, name);
        let body = method.split_once(" {\n").map_or("", |(_, body)| body);
        let mut listing = format!("fn {name}({arguments}) {{\n");
        for line in body.lines() {
            let line = line.strip_prefix("    ").unwrap_or(line);
            listing += &line
                .replace("::dsocs_core::__private::", "")
                .replace("__T::", "T::");
            listing.push('\n');
        }
        listing.push('}');
        assert!(
            book.contains(&listing),
            "the chapter on performance has to show\n{listing}"
        );
    }
}

#[test]
fn a_free_particle_needs_next_to_nothing() {
    let code = code(
        quote! {
            coordinates(x);
            lagrangian = dot(x).powi(2) / 2;
        },
        quote!(
            struct Free;
        ),
    );
    insta::assert_snapshot!(code);
}

#[test]
fn the_papers_maps_written_out_are_the_default() {
    let written = particle_with_tape(quote! {
        phi_lagrangian = |q0, q1| (q0, (q1 - q0) / h);
        phi_kinematic = |q0, q1, q2| (q1, (q2 - q0) / (2 * h), (q2 - 2 * q1 + q0) / h.powi(2));
        phi_variational = |q0, q1, q2| (q1, (q2 - q0) / (2 * h), (q2 - 2 * q1 + q0) / h.powi(2));
    });
    assert_eq!(written, particle_with_tape(quote!()));
}

#[test]
fn what_the_start_of_the_step_decides_is_not_in_the_iteration() {
    let code = particle(quote!());
    assert!(method(&code, "known").contains("__dsocs_function"));
    assert!(!method(&code, "linearize").contains("__dsocs_function"));
    assert_eq!(
        method(&code, "linearize").matches("sqrt").count(),
        1,
        "one root an iteration"
    );
    assert!(!method(&code, "report").contains("__dsocs_function"));
}

#[test]
fn a_constant_mass_leaves_no_momentum_to_subtract() {
    let code = particle(quote!());
    // Q = m e / h², without a difference of momenta; the energy stands apart
    let report = method(&code, "report");
    let force = &report[..report.find("let q:").unwrap_or_default()];
    assert!(force.contains(" * ") && !force.contains(" - "), "{force}");
}

/// In an autonomous system no code of the step reads the clock, except to report the time of a node. External
/// forces do not change that.
#[test]
fn time_that_is_not_declared_is_only_reported() {
    let item = || {
        quote!(
            struct Damped {
                damping: f64,
            }
        )
    };
    let of = |force: TokenStream, item: TokenStream| {
        let declaration = quote! {
            coordinates(x, y);
            lagrangian = (dot(x).powi(2) + dot(y).powi(2)) / 2 - x.powi(2) * y.powi(2);
            kinematic = ddot(x) + y * dot(x);
            constraint_forces = [(1, 0)];
            external_forces = (-damping * dot(x), #force);
        };
        code(declaration, item)
    };
    let (autonomous, driven) = (
        of(quote!(-dot(y) * x), item()),
        of(quote!(-dot(y) * x + t.sin()), item()),
    );
    assert_eq!(autonomous.matches("leg.t").count(), 1, "{autonomous}");
    assert_eq!(method(&autonomous, "report").matches("leg.t").count(), 1);
    assert!(autonomous.contains("const DEPENDS_ON_TIME: bool = false;"));
    for extra in [
        quote!(),
        quote!(phi_lagrangian = midpoint;),
        quote!(phi_lagrangian = trapezoid;),
    ] {
        assert_eq!(particle(extra).matches("leg.t").count(), 1);
    }
    // with a declared time, its sine is known before the iteration
    assert!(driven.contains("const DEPENDS_ON_TIME: bool = true;"));
    assert!(method(&driven, "known").contains("leg.t") && !method(&driven, "linearize").contains("sin"));
}

#[test]
fn an_absent_function_is_not_called() {
    let code = code(
        quote! {
            coordinates(x);
            lagrangian = dot(x).powi(2) / 2 - stiffness / 2 * x.powi(2);
        },
        quote!(
            struct Spring {
                stiffness: f64,
            }
        ),
    );
    for function in ["sqrt", "sin", "from_lanes", "select"] {
        assert!(!code.contains(function), "{function}");
    }
}

/// The number of operations in the rows and the Jacobian of a chain with some links.
fn operations_of_a_chain(links: usize) -> usize {
    let links = Literal::usize_unsuffixed(links);
    let code = code(
        quote! {
            coordinates(theta: [#links]);
            let beyond = |i| sum(i..#links, |k| masses[k]);
            let cosine = |i, j| theta[i].cos() * theta[j].cos() + theta[i].sin() * theta[j].sin();
            let speed = |i| lengths[i] * dot(theta[i]);
            lagrangian = sum(0..#links, |i| {
                beyond(i) * (speed(i).powi(2) / 2 + sum(0..i, |j| cosine(i, j) * speed(i) * speed(j)))
            });
            phi_lagrangian = midpoint;
        },
        quote!(
            struct Chain {
                masses: [f64; #links],
                lengths: [f64; #links],
            }
        ),
    );
    let linearize = method(&code, "linearize");
    [" + ", " - ", " * "]
        .map(|sign| linearize.matches(sign).count())
        .iter()
        .sum()
}

/// The rows of a chain take operations in proportion to the links, by running sums; an entry of the Jacobian
/// takes four.
#[test]
fn rows_of_a_chain_have_running_sums() {
    let [five, seven, nine] = [5, 7, 9].map(operations_of_a_chain);
    // the part that is quadratic in the number of links n is 4 n²
    assert_eq!(nine + five - 2 * seven, 4 * 2 * 2 * 2, "{five}, {seven}, {nine}");
    assert!(nine < 1200, "{nine}");
}
