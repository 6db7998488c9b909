//! What the whole-program tests in `tests/tests/` share.

pub mod browser;
