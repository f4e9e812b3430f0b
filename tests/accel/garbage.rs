//! Geometry and rays that make no sense: no panic, no hang, a bounded tree, and what makes sense beside them is still hit.

use rayloom::accel::{Accel, AccelKind, AccelOptions, NO_PRIM, PrimSet};
use rayloom::bench::stability::meshes::{Triangles, soup};
use rayloom::bench::stability::oracle::{Faults, Oracle, build};
use rayloom::bench::stability::ray_source::RaySource;
use rayloom::math::random::SplitMix64;
use rayloom::math::{Bounds, DVec3, Ray, Vec3};
use std::time::Instant;

const KINDS: [AccelKind; 9] = crate::TREES;
/// No tree may be deeper.
const DEEPEST: usize = 60;

/// A sane soup with garbage among it, and the number of garbage faces that cannot be built over.
fn with_garbage(bad: &[[Vec3; 3]]) -> Triangles {
    let mut t = soup(150, 0.5, 23);
    for (k, corners) in bad.iter().enumerate() {
        t.add(corners.map(|p| p.as_dvec3()));
        // Among the others, not after them.
        let last = t.faces.len() - 1;
        t.faces.swap(k, last);
    }
    t
}

#[test]
fn garbage_faces_do_no_harm_to_the_others() {
    let (nan, inf) = (Vec3::splat(f32::NAN), Vec3::splat(f32::INFINITY));
    let mut bad = vec![
        [nan, Vec3::X, Vec3::Y],
        [inf, Vec3::X, Vec3::Y],
        [-inf, inf, Vec3::ZERO],
        [Vec3::new(f32::NAN, 0.0, 0.0), Vec3::X, Vec3::Y],
        [Vec3::X; 3],
        [Vec3::X, Vec3::X, Vec3::Y],
        [Vec3::ZERO, Vec3::X, Vec3::X * 2.0],
        [Vec3::splat(1e-42), Vec3::splat(2e-42), Vec3::X * 1e-42],
    ];
    bad.extend([[Vec3::Y * 0.5; 3]; 50]);
    let mesh = with_garbage(&bad);
    let oracle = Oracle::new(&mesh);
    let sane = soup(150, 0.5, 23);
    for kind in KINDS {
        let tree = build(kind, &mesh);
        assert_eq!(tree.stats().n_skipped, 4, "{kind:?}");
        let mut faults = Faults::default();
        for ray in RaySource::new(&sane, 1).take(50_000) {
            // NaN is no depth: brute force drops it as the trees do.
            oracle.check(&tree, &ray, oracle.brute(&ray), &mut faults);
        }
        assert!(faults.none(), "{kind:?} {faults:?}");
    }
}

#[test]
fn huge_faces_are_hit_and_hide_nothing() {
    let far = |s: f32| [Vec3::new(-s, 2.0, -s), Vec3::new(s, 2.0, -s), Vec3::new(0.0, 2.0, s)];
    let mesh = with_garbage(&[far(1e6), far(1e9)]);
    let oracle = Oracle::new(&mesh);
    let sane = soup(150, 0.5, 23);
    for kind in KINDS {
        let tree = build(kind, &mesh);
        let (mut faults, mut up) = (Faults::default(), 0);
        for ray in RaySource::new(&sane, 2).take(50_000) {
            let truth = oracle.brute(&ray);
            up += usize::from(truth.t < f64::INFINITY);
            oracle.check(&tree, &ray, truth, &mut faults);
        }
        assert!(faults.none() && up > 20_000, "{kind:?} {faults:?}");
    }
}

/// Boxes as they come.
struct Boxes(Vec<Bounds>);

impl PrimSet for Boxes {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, prim_ix: usize) -> Bounds {
        self.0[prim_ix]
    }
}

fn boxes(n: usize, at: impl Fn(usize, &mut SplitMix64) -> Bounds) -> Boxes {
    let mut r = SplitMix64(31);
    Boxes((0..n).map(|k| at(k, &mut r)).collect())
}

#[test]
fn hostile_sets_of_boxes_build_quickly_and_stay_shallow() {
    let cube = |c: DVec3, r: f64| Bounds { min: c - r, max: c + r };
    let n = 20_000;
    let sets: Vec<(&str, Boxes)> = vec![
        ("all the same", boxes(n, |_, _| cube(DVec3::ONE, 1.0))),
        ("the same point", boxes(n, |_, _| cube(DVec3::ONE, 0.0))),
        ("one inside the other", boxes(n, |k, _| cube(DVec3::ZERO, 1.0 + k as f64))),
        ("side by side, ever smaller", boxes(n, |k, _| cube(DVec3::splat(0.999f64.powi(k as i32)), 0.0))),
        ("powers of two", boxes(n, |k, _| cube(DVec3::X * 2f64.powi(k as i32 % 190 - 95), 0.0))),
        ("all sizes in one place", boxes(n, |_, r| cube(r.cube(), 10f64.powf(60.0 * r.unit() - 30.0)))),
        ("infinite", boxes(n, |k, r| if k % 2 == 0 { cube(r.cube(), f64::INFINITY) } else { cube(r.cube(), 0.1) })),
        ("huge", boxes(n, |_, r| cube(r.cube() * 1e30, 1e29))),
        ("beyond any f32", boxes(n, |_, r| cube(r.cube() * 1e300, 1e299))),
        ("denormal", boxes(n, |_, r| cube(r.cube() * 1e-40, 1e-41))),
        ("NaN and empty", boxes(n, |k, r| if k % 3 == 0 { cube(DVec3::NAN, 1.0) } else { cube(r.cube(), (k % 3) as f64 - 1.5) })),
        ("a line of points", boxes(n, |k, _| cube(DVec3::X * k as f64, 0.0))),
        ("one far away", boxes(n, |k, r| cube(if k == 0 { DVec3::splat(1e29) } else { r.cube() }, 0.01))),
    ];
    for (name, set) in &sets {
        for kind in KINDS {
            let start = Instant::now();
            let tree = Accel::build(kind, set, &AccelOptions::default());
            let s = tree.stats();
            assert!(start.elapsed().as_secs_f64() < 5.0, "{name}: {kind:?} took {:?}", start.elapsed());
            assert!(s.depth <= DEEPEST && s.n_bytes < n * 400 && s.sah_cost.is_finite(), "{name}: {kind:?} {s:?}");
            match &tree {
                Accel::Kd(t) => assert!(t.is_sound(n), "{name}"),
                Accel::Bvh(t) => assert!(t.is_sound(n) && t.refs.len() == n - s.n_skipped, "{name}"),
                Accel::BvhSkip(t) => assert!(t.refs.len() == n - s.n_skipped, "{name}"),
                Accel::Wide(t) => assert!(t.is_sound(n) && t.refs.len() == n - s.n_skipped, "{name}"),
                Accel::Bvh8(t) => assert!(t.is_sound(n) && t.slots.iter().filter(|p| **p != NO_PRIM).count() == n - s.n_skipped, "{name}"),
                Accel::Grid(t) => assert!(t.is_sound(n), "{name}"),
                Accel::Brute(_) => panic!("a tree was asked for"),
            }
            // Every box that has a middle is offered to a ray through it.
            for k in (0..n).step_by(1999) {
                let b = set.bounds(k);
                if b.is_empty() || !b.center().is_finite() || b.center().abs().max_element() > 1e29 {
                    continue;
                }
                let ray = Ray::new(b.center() - DVec3::Z * (1.0 + b.center().z.abs()), DVec3::Z);
                assert!(tree.any(&ray, 0.0, f64::INFINITY, |p| p as usize == k), "{name}: {kind:?} does not offer box {k}");
            }
        }
    }
}

#[test]
fn rays_without_sense_meet_nothing_and_end() {
    let mesh = soup(500, 0.5, 29);
    let (nan, inf) = (f64::NAN, f64::INFINITY);
    for kind in KINDS.into_iter().chain([AccelKind::Brute]) {
        let tree = build(kind, &mesh);
        let offered = |origin: DVec3, dir: DVec3, t_min: f64, t_max: f64| {
            let ray = Ray::new(origin, dir);
            let mut n = 0;
            tree.closest(&ray, t_min, t_max, |_, _| {
                n += 1;
                None
            });
            assert_eq!(tree.any(&ray, t_min, t_max, |_| true), n > 0, "{kind:?} {ray:?} {t_min} {t_max}");
            n
        };
        for bad in [nan, inf, -inf] {
            for k in 0..3 {
                let mut v = DVec3::splat(0.1);
                v[k] = bad;
                assert_eq!(offered(v, DVec3::X, 0.0, 9.0), 0, "{kind:?}");
                assert_eq!(offered(DVec3::ZERO, v, 0.0, 9.0), 0, "{kind:?}");
            }
        }
        assert_eq!(offered(DVec3::ZERO, DVec3::ZERO, 0.0, 9.0), 0, "{kind:?}");
        assert!(offered(DVec3::splat(-2.0), DVec3::ONE, -0.0, inf) > 0, "{kind:?}");
        assert!(offered(DVec3::splat(-2.0), DVec3::ONE, -5.0, 9.0) > 0, "{kind:?}");
        assert!(offered(DVec3::splat(-2e-300), DVec3::splat(1e-300), 0.0, inf) > 0, "{kind:?}");
        assert!(offered(DVec3::splat(-2.0), DVec3::splat(1e300), 0.0, inf) > 0, "{kind:?}");
        // Nothing is asked of an interval without depths.
        for (t_min, t_max) in [(2.0, 1.0), (nan, 1.0), (0.0, nan), (0.0, -1.0)] {
            assert_eq!(offered(DVec3::splat(-2.0), DVec3::ONE, t_min, t_max), 0, "{kind:?} {t_min} {t_max}");
        }
        // Far outside the range of the tree's numbers.
        offered(DVec3::splat(1e308), -DVec3::ONE, 0.0, inf);
        offered(DVec3::splat(-1e300), DVec3::new(1.0, 1e-300, -1e-300), 0.0, inf);
    }
}

#[test]
fn nothing_and_a_single_primitive_have_their_trees() {
    for kind in KINDS.into_iter().chain([AccelKind::Auto, AccelKind::Brute]) {
        let none = build(kind, &Triangles::default());
        assert!(!none.any(&Ray::new(DVec3::ZERO, DVec3::X), 0.0, 1.0, |_| true));
        for n in 1..12 {
            let mesh = soup(n, 0.5, n as u64);
            let (tree, oracle) = (build(kind, &mesh), Oracle::new(&mesh));
            let mut faults = Faults::default();
            RaySource::new(&mesh, 5).take(2000).for_each(|ray| oracle.check(&tree, &ray, oracle.brute(&ray), &mut faults));
            assert!(faults.none(), "{kind:?} over {n}: {faults:?}");
        }
    }
}
