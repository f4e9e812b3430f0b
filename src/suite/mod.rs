//! The picture suite: small scenes in folders, rendered and held against reference pictures. It starts the program for each picture,
//! so that a crash is one case's failure, and knows nothing of what a scene holds.

mod case_run;
mod child;
mod command;
mod discover;
mod engine;
mod error;
mod estimate;
mod judge;
mod junit;
mod limits;
mod report;
mod results;
mod spec;
mod texts;
mod update;

pub use command::quoted;
pub use discover::{Case, Suite};
pub use engine::{SuiteOptions, run};
pub use error::SuiteError;
pub use judge::{Pair, judge};
pub use junit::junit;
pub use limits::Limits;
pub use report::{ReportOptions, write as write_report};
pub use results::{CaseResult, Numbers, PairResult, RunResult, State, SuiteResults, TextResult};
pub use spec::{CaseFile, Expect, KnownFailure, Machine, PictureKind, SuiteFile};
pub use update::{make_references, new_case, update};
