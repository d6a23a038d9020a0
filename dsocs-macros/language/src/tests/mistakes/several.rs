//! Several mistakes at once, and what remains of a wrong declaration.

use crate::tests::mistakes::{mistakes_on, one};
use crate::tests::{ITEM, analyzed};

#[test]
fn the_second_of_two_names_is_shown() {
    let Err(mistakes) = analyzed(
        "coordinates(x); let mass = 1; lagrangian = dot(x);",
        "struct A { mass: f64 }",
    ) else {
        panic!("the clash was not found")
    };
    // the field's tokens come from another source, where they are in the first line
    assert_eq!(mistakes.errors[0].span().start().column, "struct A { ".len());
}

#[test]
fn every_mistake_is_reported_in_the_order_of_the_source() {
    let declaration = "coordinates(x, y);\n\
         let a = xx + dot(dddot(y));\n\
         lagrangian = a + ddot(x) + \"s\";\n\
         kinematic = [a, x, thta];\n\
         constraint_forces = [(zz, 1)];\n\
         observe = [b];\n\
         wrong = 1;";
    let places: Vec<_> = mistakes_on(declaration, ITEM)
        .into_iter()
        .map(|(place, _)| place)
        .collect();
    assert_eq!(
        places,
        [
            "xx",
            "dot(dddot(y))",
            "\"s\"",
            "x",
            "thta",
            "constraint_forces",
            "zz",
            "b",
            "wrong"
        ]
    );
}

#[test]
fn one_mistake_gives_one_error() {
    one(
        "coordinates(x, y); let w = dot(x) + mas; let v = w * w; lagrangian = v; kinematic = dot(v); \
         constraint_forces = [(v, 1)]; branch = divide(w); observe = [v, w];",
        "mas",
        "did you mean `mass`?",
    );
}

#[test]
fn a_wrong_declaration_leaves_an_implementation() {
    let Err(mistakes) = analyzed(
        "coordinates(x, y); lagrangian = z;",
        "struct A<'a, T: Copy = f64> where T: B { t: &'a T }",
    ) else {
        panic!("the mistake was not found")
    };
    let stub = mistakes.stub.to_string();
    syn::parse_str::<syn::File>(&stub).unwrap();
    assert!(
        stub.contains(
            "impl < 'a , T : Copy > :: dsocs_core :: System < 2usize > for A < 'a , T > where T : B"
        ),
        "{stub}"
    );
}
