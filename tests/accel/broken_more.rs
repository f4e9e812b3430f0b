//! As `broken`, for skip links, nodes of eight and grids.

use crate::broken::faults_of;
use rayloom::accel::{Accel, AccelKind, BVH8_LEAF, Bvh8, BvhSkip, GRID_INNER, Grid, WideBvh, leaf_slots};

fn skip_faults(damage: impl FnOnce(&mut BvhSkip)) -> bool {
    faults_of(AccelKind::BvhSkip, |t| {
        let Accel::BvhSkip(t) = t else { panic!("a BVH with skip links was asked for") };
        damage(t);
    })
    .lost()
}

fn wide_faults(damage: impl FnOnce(&mut WideBvh)) -> bool {
    faults_of(AccelKind::Wide, |t| {
        let Accel::Wide(t) = t else { panic!("a wide BVH was asked for") };
        assert!(t.is_sound(t.refs.len()));
        damage(t);
    })
    .lost()
}

fn bvh8_faults(damage: impl FnOnce(&mut Bvh8)) -> bool {
    faults_of(AccelKind::Bvh8, |t| {
        let Accel::Bvh8(t) = t else { panic!("a BVH of eight was asked for") };
        damage(t);
    })
    .lost()
}

fn grid_faults(kind: AccelKind, damage: impl FnOnce(&mut Grid)) -> bool {
    faults_of(kind, |t| {
        let Accel::Grid(t) = t else { panic!("a grid was asked for") };
        assert!(t.is_sound(t.stats.n_prims));
        damage(t);
    })
    .lost()
}

#[test]
fn a_skip_link_too_far_is_caught() {
    assert!(skip_faults(|t| {
        let k = t.nodes.iter().position(|n| n.leaf != 0).expect("a leaf");
        let beyond = t.nodes[t.nodes[k].skip as usize].skip;
        t.nodes[k - 1].skip = beyond.max(t.nodes[k - 1].skip) + 2;
    }));
    assert!(skip_faults(|t| t.nodes[4].lo[1] += 0.05));
    assert!(skip_faults(|t| t.refs[7] = t.refs[8]));
}

#[test]
fn damage_to_wide_nodes_is_caught() {
    // A byte of a box, a step of a lattice, a child's number, a leaf's count.
    assert!(wide_faults(|t| {
        let (n, slot) = (&mut t.nodes[0], 0);
        let slot = (slot..8).find(|s| n.meta[*s] != 0).expect("a child");
        n.hi[0][slot] = n.hi[0][slot].saturating_sub(12);
    }));
    assert!(wide_faults(|t| t.nodes[0].exponents_inner[1] -= 1));
    assert!(wide_faults(|t| t.nodes[0].first_child += 1));
    assert!(wide_faults(|t| {
        let (n, s) = t.nodes.iter_mut().find_map(|n| (0..8).find(|s| n.meta[*s] >> 5 == 3).map(|s| (n, s))).expect("a leaf of two");
        n.meta[s] = 1 << 5 | n.meta[s] & 31;
    }));
}

#[test]
fn damage_to_nodes_of_eight_is_caught() {
    assert!(bvh8_faults(|t| t.nodes[0].planes[1][1][0] -= 0.01));
    assert!(bvh8_faults(|t| t.slots[0] = t.slots[4]));
    assert!(bvh8_faults(|t| {
        let inner = |c: &u32| c & BVH8_LEAF == 0;
        let child = t.nodes[0].child.iter_mut().find(|c| inner(c)).expect("an inner child");
        *child += 1;
    }));
    assert!(bvh8_faults(|t| {
        // The lowest bits hold the number of primitives less one.
        let several = |c: &u32| *c & BVH8_LEAF != 0 && leaf_slots(*c).1 > 1;
        let leaf = t.nodes.iter_mut().flat_map(|n| &mut n.child).find(|c| several(c)).expect("a leaf of several");
        *leaf -= 1;
    }));
}

#[test]
fn damage_to_grids_is_caught() {
    for kind in [AccelKind::Grid, AccelKind::HierarchicalGrid] {
        // A list cut short, a block that says "seen before", a shifted lattice.
        assert!(grid_faults(kind, |t| {
            let c = t.cells.iter_mut().filter(|c| c.count != GRID_INNER).max_by_key(|c| c.count).expect("a cell");
            c.count /= 2;
        }));
        assert!(grid_faults(kind, |t| t.entries.iter_mut().step_by(3).for_each(|e| (e.lo, e.hi) = (0, u32::MAX >> 2))));
        assert!(grid_faults(kind, |t| t.grids[0].lo[0] += 0.7 * t.grids[0].size[0]));
    }
    assert!(grid_faults(AccelKind::HierarchicalGrid, |t| {
        let c = t.cells.iter_mut().find(|c| c.count == GRID_INNER).expect("a grid in a cell");
        (c.first, c.count) = (0, 0);
    }));
}
