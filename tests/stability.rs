//! The short form of `rayloom bench stability`: every figure of the CPU's keeps its bar, or misses it for a reason that is written down.

use rayloom::bench::stability::{CASES, Effort, Peers, run};

/// Enough to see what is broken; the whole takes 1e9 (docs/stability.md).
const SHORT: Effort = Effort { rays: 20_000, gpus: false, meshes: String::new() };

#[test]
fn every_figure_keeps_its_bar() {
    let figures = run(&[], SHORT, Peers::default(), &mut |_| ());
    // Times mean little while other tests run.
    let counted = figures.iter().filter(|f| !f.what.contains("time"));
    let missed: Vec<_> = counted.filter(|f| !f.passes()).collect();
    assert!(missed.is_empty(), "{missed:#?}");
    assert!(CASES.iter().all(|c| c.number == 5 || figures.iter().any(|f| f.case == c.number)), "a case without a figure");
}
