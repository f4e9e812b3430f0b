//! Trees broken on purpose: what finds no fault in good trees must find one in each of these.

use rayloom::accel::{Accel, AccelKind, BVH_LEAF, Bvh, KdNode, KdTree};
use rayloom::bench::stability::meshes::{ball, soup};
use rayloom::bench::stability::oracle::{Faults, Oracle, build};
use rayloom::bench::stability::ray_source::RaySource;

/// Faults of a tree over a ball, before and after `damage`.
pub fn faults_of(kind: AccelKind, damage: impl FnOnce(&mut Accel)) -> Faults {
    let mut mesh = ball(2, true, 1.0);
    mesh.append(&soup(30, 0.3, 4));
    let oracle = Oracle::new(&mesh);
    let mut tree = build(kind, &mesh);
    let count = |tree: &Accel| {
        let mut faults = Faults::default();
        for ray in RaySource::new(&mesh, 21).take(60_000) {
            oracle.check(tree, &ray, oracle.brute(&ray), &mut faults);
        }
        faults
    };
    assert!(count(&tree).none(), "the tree is good before it is broken");
    damage(&mut tree);
    count(&tree)
}

fn kd_faults(damage: impl FnOnce(&mut KdTree)) -> Faults {
    faults_of(AccelKind::Kd, |t| {
        let Accel::Kd(t) = t else { panic!("a kd-tree was asked for") };
        damage(t);
    })
}

fn bvh_faults(damage: impl FnOnce(&mut Bvh)) -> Faults {
    faults_of(AccelKind::Bvh, |t| {
        let Accel::Bvh(t) = t else { panic!("a BVH was asked for") };
        damage(t);
    })
}

#[test]
fn a_dropped_reference_is_caught() {
    // A kd-tree keeps a face in several cells, and one that is whole in each can be found through any.
    let f = kd_faults(|t| t.refs.iter_mut().filter(|r| **r == 40).for_each(|r| *r = 41));
    assert!(f.missed + f.farther > 0 && f.unblocked > 0, "{f:?}");
    let f = bvh_faults(|t| t.refs[40] = t.refs[41]);
    assert!(f.missed + f.farther > 0 && f.unblocked > 0, "{f:?}");
}

#[test]
fn a_shifted_plane_is_caught() {
    let f = kd_faults(|t| {
        let n = t.nodes[0];
        t.nodes[0] = KdNode::inner(n.axis(), n.split() + 0.01, n.above_or_count());
    });
    assert!(f.missed + f.farther > 0, "{f:?}");
    let f = bvh_faults(|t| t.nodes[0].planes[1][1][0] -= 0.01);
    assert!(f.missed + f.farther > 0, "{f:?}");
}

#[test]
fn a_swapped_child_is_caught() {
    let f = kd_faults(|t| {
        // A leaf instead of the child above.
        let leaf = t.nodes.iter().rposition(|n| n.is_leaf() && n.above_or_count() > 0).expect("a leaf");
        let n = t.nodes[1];
        t.nodes[1] = KdNode::inner(n.axis(), n.split(), leaf as u32);
    });
    assert!(f.missed + f.farther > 0, "{f:?}");
    let f = bvh_faults(|t| {
        let n = t.nodes.iter_mut().find(|n| n.child.iter().all(|c| c & BVH_LEAF == 0)).expect("a node of nodes");
        n.child.swap(0, 1);
    });
    assert!(f.missed + f.farther > 0, "{f:?}");
}

#[test]
fn shrunk_bounds_are_caught() {
    let f = kd_faults(|t| t.bounds.hi[0] -= 0.002);
    assert!(f.missed + f.farther > 0, "{f:?}");
    // One leaf alone, and by little.
    let f = bvh_faults(|t| {
        let n = t.nodes.iter_mut().find(|n| n.child[0] & BVH_LEAF != 0).expect("a leaf");
        n.planes[2][0][0] += 1e-3;
    });
    assert!(f.missed + f.farther > 0, "{f:?}");
}

#[test]
fn a_shortened_leaf_is_caught() {
    let f = bvh_faults(|t| {
        let n = t.nodes.iter_mut().find(|n| n.count[1] > 1).expect("a leaf of several");
        n.count[1] -= 1;
    });
    assert!(f.missed + f.farther > 0, "{f:?}");
    let f = kd_faults(|t| {
        let k = t.nodes.iter().position(|n| n.is_leaf() && n.above_or_count() > 1).expect("a leaf of several");
        let n = t.nodes[k];
        t.nodes[k] = KdNode::leaf(n.split_or_first, n.above_or_count() - 1);
    });
    assert!(f.missed + f.farther > 0, "{f:?}");
}

#[test]
fn a_tree_that_is_unsound_says_so() {
    let Accel::Bvh(mut t) = build(AccelKind::Bvh, &soup(50, 0.2, 1)) else { panic!("a BVH was asked for") };
    assert!(t.is_sound(50) && !t.is_sound(49));
    t.refs[3] = t.refs[4];
    assert!(!t.is_sound(50));
    let Accel::Kd(mut t) = build(AccelKind::Kd, &soup(50, 0.2, 1)) else { panic!("a kd-tree was asked for") };
    assert!(t.is_sound(50) && !t.is_sound(49));
    t.nodes[0] = KdNode::inner(0, 0.0, 0);
    assert!(!t.is_sound(50));
}
