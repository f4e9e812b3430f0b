//! Results as JUnit XML, which CI systems read: an area is a test suite, a case a test.

use super::results::{CaseResult, State, SuiteResults};
use std::collections::BTreeMap;
use std::fmt::Write;

/// The XML document.
pub fn junit(results: &SuiteResults) -> String {
    let mut areas: BTreeMap<&str, Vec<&CaseResult>> = BTreeMap::new();
    for c in &results.cases {
        areas.entry(&c.area).or_default().push(c);
    }
    let counts = |cases: &[&CaseResult]| {
        let n = |s: State| cases.iter().filter(|c| c.state == s).count();
        let skipped = n(State::LeftOut) + n(State::KnownFailure);
        format!("tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{skipped}\"", cases.len(), n(State::Failed), n(State::Broken))
    };
    let all: Vec<&CaseResult> = results.cases.iter().collect();
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    // Writing to a string does not fail.
    let _ = writeln!(out, "<testsuites name=\"{}\" {} time=\"{:.3}\">", escaped(&results.title), counts(&all), results.seconds);
    for (area, cases) in &areas {
        let seconds: f64 = cases.iter().map(|c| seconds(c)).sum();
        let _ = writeln!(out, "  <testsuite name=\"{}\" {} time=\"{seconds:.3}\">", escaped(area), counts(cases));
        cases.iter().for_each(|c| case(&mut out, c));
        out.push_str("  </testsuite>\n");
    }
    if !results.faults.is_empty() {
        let n = results.faults.len();
        let _ = writeln!(out, "  <testsuite name=\"suite\" tests=\"{n}\" failures=\"{n}\" errors=\"0\" skipped=\"0\" time=\"0\">");
        for f in &results.faults {
            let f = escaped(f);
            let _ = writeln!(out, "    <testcase classname=\"suite\" name=\"{f}\" time=\"0\"><failure message=\"{f}\"/></testcase>");
        }
        out.push_str("  </testsuite>\n");
    }
    out.push_str("</testsuites>\n");
    out
}

fn seconds(c: &CaseResult) -> f64 {
    if c.reused { 0.0 } else { c.runs.iter().map(|r| r.seconds).sum() }
}

fn case(out: &mut String, c: &CaseResult) {
    let short = c.name.rsplit('/').next().unwrap_or(&c.name);
    let _ = write!(out, "    <testcase classname=\"{}\" name=\"{}\" time=\"{:.3}\"", escaped(&c.area), escaped(short), seconds(c));
    let why = escaped(&c.why.join("\n"));
    let first = escaped(c.why.first().map_or("", String::as_str));
    let again = escaped(&c.runs.iter().map(|r| r.command.clone()).collect::<Vec<_>>().join("\n"));
    let _ = match c.state {
        State::Passed => writeln!(out, "/>"),
        State::LeftOut | State::KnownFailure => writeln!(out, "><skipped message=\"{}: {first}\"/></testcase>", c.state.word()),
        State::Failed => writeln!(out, "><failure message=\"{first}\">{why}\n{again}</failure></testcase>"),
        State::Broken => writeln!(out, "><error message=\"{first}\">{why}\n{again}</error></testcase>"),
    };
}

/// Text as XML takes it; control characters, which it does not, become spaces.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\n' => out.push_str("&#10;"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}
