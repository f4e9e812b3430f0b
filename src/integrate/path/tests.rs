//! Pictures with known answers.
