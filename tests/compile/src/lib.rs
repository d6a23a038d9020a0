//! Nothing but tests: see `tests/compile_errors.rs` and `tests/right`.
