//! Each kind of mistake in a declaration is told at the user's own tokens.
//!
//! What the attribute itself tells stands together by its subject; what the compiler tells of code of the user's, file by file, since it
//! gets that far only where nothing else is wrong.

#[test]
fn wrong_declarations() {
    trybuild::TestCases::new().compile_fail("compile-fail/*.rs");
}
