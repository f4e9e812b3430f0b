//! The picture suite: small scenes in folders, rendered and held against reference pictures. It starts the program for each picture,
//! so that a crash is one case's failure, and knows nothing of what a scene holds.

mod discover;
mod spec;

pub use discover::{Case, Suite};
pub use spec::{CaseFile, Expect, KnownFailure, Limits, Machine, PictureKind, SuiteError, SuiteFile};
