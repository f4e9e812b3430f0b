//! Every structure gives brute force's hits.

use crate::TREES;
use rayloom::accel::{Accel, AccelKind, AccelOptions, BoxF, Bvh, KdTree, NO_PRIM, TrianglePrims};
use rayloom::bench::stability::meshes::*;
use rayloom::bench::stability::oracle::{Faults, Oracle, build};
use rayloom::bench::stability::ray_source::RaySource;
use rayloom::math::Ray;

const N_RAYS: usize = 1_000_000;

/// Every structure over `mesh` against every face of it, for a million rays.
fn agree_on(mesh: &Triangles) {
    assert!(mesh.faces.len() <= 320, "every ray is held against every face");
    agree_with(mesh, &Oracle::new(mesh), mesh, |_| true);
}

/// As `agree_on`, with the truth from `oracle` for the rays that `asked` picks; the trees must agree with each other on all.
fn agree_with(mesh: &Triangles, truth: &Oracle, aims: &Triangles, asked: impl Fn(usize) -> bool) {
    let own = Oracle::new(mesh);
    let trees = TREES.map(|kind| build(kind, mesh));
    assert_eq!(trees.each_ref().map(Accel::kind), TREES);
    let (mut faults, mut n_hits, mut n_apart) = (TREES.map(|_| Faults::default()), 0, 0);
    for (k, ray) in RaySource::new(aims, 3).take(N_RAYS).enumerate() {
        if asked(k) {
            let depth = truth.brute(&ray);
            n_hits += usize::from(depth.t < f64::INFINITY);
            trees.iter().zip(&mut faults).for_each(|(tree, faults)| own.check(tree, &ray, depth, faults));
        } else {
            n_hits += usize::from(own.any(&trees[0], &ray, f64::INFINITY));
            let depths = trees.each_ref().map(|t| own.closest(t, &ray));
            n_apart += usize::from(depths.iter().any(|t| (depths[0] - t).abs() > 1e-6));
        }
    }
    assert!(n_hits > N_RAYS / 20, "rays that hit nothing prove nothing: {n_hits} hits");
    // Infinity less infinity is no difference; edge on, depths are no better than this.
    assert!(n_apart * 50_000 < N_RAYS, "trees differ for {n_apart} rays");
    for (kind, faults) in TREES.iter().zip(faults) {
        assert!(faults.none(), "{}: {faults:?} of {n_hits} hits", kind.name());
    }
}

#[test]
fn trees_give_brute_forces_hits_on_a_soup() {
    agree_on(&soup(250, 0.5, 1));
}

#[test]
fn trees_give_brute_forces_hits_on_a_closed_ball() {
    agree_on(&ball(2, true, 1.0));
}

#[test]
fn trees_give_brute_forces_hits_on_a_flat_grid() {
    agree_on(&flat(11));
}

#[test]
fn trees_give_brute_forces_hits_on_needles() {
    agree_on(&needles(200));
}

#[test]
fn trees_give_brute_forces_hits_far_from_the_origin() {
    agree_on(&ball(2, true, 2.0).mapped(|p| p + FAR_AWAY));
}

#[test]
fn trees_give_brute_forces_hits_on_a_teapot_in_a_stadium() {
    agree_on(&teapot_in_stadium());
}

#[test]
fn trees_give_brute_forces_hits_on_a_thousand_duplicates() {
    let single = soup(100, 0.4, 5);
    let mut many = single.clone();
    (0..1000).for_each(|_| many.faces.push(single.faces[0]));
    agree_with(&many, &Oracle::new(&single), &single, |_| true);
}

#[test]
fn trees_give_brute_forces_hits_on_a_terrain() {
    agree_on(&terrain(12));
}

#[test]
fn trees_give_brute_forces_hits_on_boxes_that_share_faces() {
    agree_on(&nested_boxes(16));
}

#[test]
fn trees_agree_on_larger_meshes_and_with_brute_force_on_a_sample() {
    for mesh in [soup(20_000, 0.05, 9), terrain(100)] {
        agree_with(&mesh, &Oracle::new(&mesh), &mesh, |k| k % 1009 < 2);
    }
}

#[test]
fn trees_do_not_depend_on_the_number_of_threads() {
    let mesh = soup(100_000, 0.02, 13);
    let prims = TrianglePrims { vertices: &mesh.vertices, faces: &mesh.faces };
    let with = |n| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("a pool");
        pool.install(|| (KdTree::build(&prims, &AccelOptions::default()), Bvh::build(&prims, &AccelOptions::default())))
    };
    let one = with(1);
    for n in [2, 7] {
        let (kd, bvh) = with(n);
        assert!(kd.nodes == one.0.nodes && kd.refs == one.0.refs, "kd-tree with {n} threads");
        assert!(bvh.nodes == one.1.nodes && bvh.refs == one.1.refs, "BVH with {n} threads");
    }
}

fn holds(outer: &BoxF, inner: &BoxF) -> bool {
    (0..3).all(|k| outer.lo[k] <= inner.lo[k] && outer.hi[k] >= inner.hi[k])
}

/// Every box of the node and below holds what is under it.
fn check_boxes(t: &Bvh, mesh: &Triangles, node: usize) -> BoxF {
    let n = &t.nodes[node];
    let mut all = BoxF::EMPTY;
    for c in 0..2 {
        let own = n.child_box(c);
        if n.child[c] & rayloom::accel::BVH_LEAF != 0 {
            let first = (n.child[c] ^ rayloom::accel::BVH_LEAF) as usize;
            for r in &t.refs[first..first + n.count[c] as usize] {
                for p in mesh.faces[*r as usize].map(|v| mesh.vertices[v as usize].to_array()) {
                    assert!(holds(&own, &BoxF { lo: p, hi: p }), "face {r} sticks out of its leaf");
                }
            }
        } else {
            assert!(holds(&own, &check_boxes(t, mesh, n.child[c] as usize)), "node {node}");
        }
        all.grow(&own);
    }
    all
}

#[test]
fn bvh_boxes_hold_what_is_below_and_its_statistics_are_true() {
    let mesh = soup(5000, 0.1, 17);
    let Accel::Bvh(t) = build(AccelKind::Bvh, &mesh) else { panic!("a BVH was asked for") };
    assert!(t.is_sound(5000));
    check_boxes(&t, &mesh, 0);
    let s = t.stats;
    assert_eq!((s.n_prims, s.n_skipped, s.n_refs, s.n_nodes), (5000, 0, 5000, t.nodes.len()));
    assert_eq!((s.n_leaves, s.n_bytes), (t.nodes.len() + 1, t.nodes.len() * 64 + 5000 * 4));
    let counts: Vec<u32> = t.nodes.iter().flat_map(|n| n.count).filter(|c| *c > 0).collect();
    assert_eq!((counts.len(), counts.iter().sum::<u32>()), (s.n_leaves, 5000));
    assert!(counts.iter().all(|c| *c <= 4) && s.depth > 8 && s.depth < 40 && s.sah_cost > 1.0 && s.build_seconds > 0.0, "{s:?}");
}

#[test]
fn slots_name_each_primitive_once() {
    let mesh = soup(500, 0.1, 19);
    for kind in TREES.into_iter().chain([AccelKind::Brute]) {
        let tree = build(kind, &mesh);
        let mut slots = tree.slots();
        assert!(slots.iter().enumerate().all(|(k, p)| tree.prim_at(k as u32) == *p));
        slots.retain(|p| *p != NO_PRIM);
        slots.sort_unstable();
        assert!(slots.iter().copied().eq(0..500));
        let ray = Ray::new(rayloom::math::DVec3::splat(-3.0), rayloom::math::DVec3::ONE);
        let (mut by_slot, mut by_prim) = (Vec::new(), Vec::new());
        tree.closest_slots(&ray, 0.0, 10.0, |s, _| {
            by_slot.push(tree.prim_at(s));
            None
        });
        tree.closest(&ray, 0.0, 10.0, |p, _| {
            by_prim.push(p);
            None
        });
        assert!(!by_prim.is_empty() && by_slot == by_prim);
    }
}
