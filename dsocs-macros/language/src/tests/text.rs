//! Declarations as Rust text, without a compiler: what is accepted, and the places of mistakes.

use crate::{Mistake, Model, analyze};

/// The mistakes of a text, as `line:column-line:column` and message.
fn mistakes(text: &str) -> Vec<(String, String)> {
    let place = |mistake: Mistake| {
        let Mistake {
            line,
            column,
            end_line,
            end_column,
            message,
        } = mistake;
        (format!("{line}:{column}-{end_line}:{end_column}"), message)
    };
    analyze(text)
        .err()
        .unwrap_or_default()
        .into_iter()
        .map(place)
        .collect()
}

#[track_caller]
fn one(text: &str, place: &str, message: &str) {
    let found = mistakes(text);
    let right = found.len() == 1 && found[0].0 == place && found[0].1.contains(message);
    assert!(right, "expected `{message}` at {place}, found {found:#?}");
}

const SPRING: &str = "\
/// A mass on a spring.
#[derive(Clone)]
#[dsocs_core::dsocs {
    coordinates(x);
    lagrangian = dot(x).powi(2) / 2 - stiffness / 2 * x.powi(2);
    let force = -stiffness * x;
    observe = [force];
}]
#[must_use]
struct r#Spring { stiffness: f64, r#type: f64 }";

#[test]
fn a_struct_with_its_attribute_has_a_model() {
    let model: Model = analyze(SPRING).unwrap();
    assert_eq!(model.name(), "Spring");
    assert_eq!(model.coordinates(), ["x"]);
    assert_eq!(model.parameters(), ["stiffness", "type"]);
    assert_eq!(model.observables(), ["force"]);
    // other attributes belong to the struct
    let code = syn::parse2::<syn::File>(model.code()).unwrap();
    let syn::Item::Struct(item) = &code.items[0] else {
        panic!("the struct comes first");
    };
    let names: Vec<_> = item
        .attrs
        .iter()
        .map(|attribute| attribute.path().get_ident().unwrap().to_string())
        .collect();
    assert_eq!(names, ["doc", "derive", "must_use"]);
}

#[test]
fn tokens_are_as_good_as_text() {
    let tokens: proc_macro2::TokenStream = SPRING.parse().unwrap();
    let (from_tokens, from_text) = (analyze(tokens).unwrap(), analyze(SPRING).unwrap());
    assert_eq!(from_tokens.code().to_string(), from_text.code().to_string());
}

#[test]
fn mistakes_are_where_they_are_in_the_text() {
    let text = "#[dsocs {\n    coordinates(x);\n    lagrangian = dot(x) * speed;\n    holonomic = ddot(x) + ü;\n}]\nstruct A;";
    let found = mistakes(text);
    let places: Vec<_> = found.iter().map(|(place, _)| place.as_str()).collect();
    assert_eq!(places, ["3:27-3:32", "4:27-4:28"], "{found:#?}");
    // columns are counted in characters, from 1
    one(
        "#[dsocs { coordinates(ä); let ö = ü; lagrangian = dot(ä) * dot(ä); }] struct A;",
        "1:35-1:36",
        "`ü`",
    );
}

#[test]
fn what_is_missing_is_missed_at_the_attribute() {
    one(
        "\n  #[dsocs { coordinates(x); }]\nstruct A;",
        "2:5-2:10",
        "`lagrangian = …;`",
    );
    one("#[my::dsocs]\nstruct A;", "1:7-1:12", "`coordinates(x, y);`");
}

#[test]
fn what_is_no_struct_with_the_attribute_is_refused() {
    one("struct A;", "1:1-1:10", "the attribute `#[dsocs { … }]`");
    one("fn f() {}", "1:1-1:10", "the attribute `#[dsocs { … }]`");
    one(
        "#[dsocs { coordinates(x); lagrangian = dot(x) * dot(x); }]\nenum A {}",
        "2:1-2:5",
        "struct",
    );
    one(
        "#[dsocs { coordinates(x); lagrangian = dot(x) * dot(x); }]\nstruct A {",
        "2:10-2:10",
        "a bracket",
    );
    one("#[dsocs { coordinates(x); }]", "1:1-1:1", "");
    assert_eq!(mistakes("").len(), 1);
}
