//! Each kind of mistake in a declaration is told at the user's own tokens, and what is right compiles.

#[test]
fn wrong_declarations() {
    trybuild::TestCases::new().compile_fail("compile-fail/*.rs");
}

#[test]
fn right_declarations() {
    trybuild::TestCases::new().pass("compile-pass/*.rs");
}
