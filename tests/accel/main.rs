//! The trees against brute force, with broken trees that must be caught, garbage, and closed meshes that must not leak.
//!
//! Scenes are small enough for every ray to be held against every primitive; the larger ones sample their rays.

mod broken;
mod broken_more;
mod garbage;
mod packets;
mod scene;
mod trees;
mod watertight;

use rayloom::accel::AccelKind;

/// All structures that are not brute force.
const TREES: [AccelKind; 9] = [
    AccelKind::Kd,
    AccelKind::Bvh,
    AccelKind::BvhSkip,
    AccelKind::Wide,
    AccelKind::Bvh8,
    AccelKind::Grid,
    AccelKind::HierarchicalGrid,
    AccelKind::KdShort,
    AccelKind::KdRestart,
];

#[test]
fn no_structure_is_left_out() {
    let brute = |k: &AccelKind| matches!(k, AccelKind::Brute | AccelKind::BruteTiled | AccelKind::BruteGroup);
    let all: Vec<AccelKind> = rayloom::accel::STRUCTURES.iter().map(|s| s.kind).filter(|k| !brute(k)).collect();
    assert!(all.len() == TREES.len() && all.iter().all(|k| TREES.contains(k)), "{all:?}");
}
