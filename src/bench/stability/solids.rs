//! Cases 17 to 19 and 21: what goes in comes out, one winner for coincident faces, instances like flattened meshes.

use super::figures::{Report, compiled, largest, mesh_scene, scene, total};
use super::meshes::{ball, terrain};
use crate::accel::AccelKind;
use crate::compile::CompiledScene;
use crate::kernel::intersect::{HitSink, LocalRay, Part, intersect_shape};
use crate::kernel::traverse::{MIN_DEPTH, intersect};
use crate::math::random::SplitMix64;
use crate::math::{DAffine3, DMat3, DVec3, Ray, Transform};
use crate::scene::{Mesh, Object, Scene, Shape};
use std::sync::Arc;

const FAR: f64 = 1e7;

/// All hits of a shape.
#[derive(Default)]
struct All(Vec<f64>);

impl HitSink for All {
    fn push(&mut self, t: f64, _: Part) {
        self.0.push(t);
    }

    fn far(&self) -> f64 {
        f64::INFINITY
    }
}

/// Hits of the first primitive, in its own space.
fn n_hits(scene: &CompiledScene, ray: &Ray) -> usize {
    let g = &scene.geometry;
    let prim = &g.prims[0];
    let t = &g.transforms[prim.transform_ix as usize];
    let dir = t.inverse_vector(ray.dir);
    let scale = dir.length();
    let mut all = All::default();
    intersect_shape(scene, prim, &LocalRay { origin: t.inverse_point(ray.origin), dir: dir / scale, scale }, &mut all);
    all.0.len()
}

pub(super) fn parity(report: &mut Report) {
    let shapes = [
        ("cylinder", "cylinder { -y, y, 1 pigment { rgb 1 } }"),
        ("cone", "cone { -y, 1, y, 0.5 pigment { rgb 1 } }"),
        ("cone with an apex", "cone { -y, 1, y, 0 pigment { rgb 1 } }"),
    ];
    let n = report.rays(10);
    for (name, text) in shapes {
        let scene = scene(text);
        let apex = if name.ends_with("apex") { 0.0 } else { 1.0 };
        type RayMaker<'a> = &'a (dyn Fn(&mut SplitMix64) -> Ray + Sync);
        let targets: [(&str, RayMaker); 4] = [
            ("random", &|r| {
                let from = 5.0 * r.direction();
                Ray::new(from, (r.cube() - from).normalize())
            }),
            ("parallel to the axis", &|r| {
                let p = r.cube();
                Ray::new(DVec3::new(p.x, -5.0, p.z), DVec3::Y)
            }),
            ("at the rim", &|r| {
                let a = std::f64::consts::TAU * r.unit();
                let from = 5.0 * r.direction();
                Ray::new(from, (DVec3::new(a.cos(), -1.0, a.sin()) - from).normalize())
            }),
            ("at the middle of the top", &|r| {
                let from = 5.0 * r.direction();
                Ray::new(from, (DVec3::new(0.0, 1.0, 0.0) - apex * 1e-3 * DVec3::Y - from).normalize())
            }),
        ];
        for (which, ray) in targets {
            let odd = total(n, 21, |r| n_hits(&scene, &ray(r)) as u64 % 2);
            report.cpu(format!("rays that go in and not out, {name}, {which}"), odd as f64, 0.0, n);
        }
    }
}

pub(super) fn coincident(report: &mut Report) {
    let n = report.rays(10);
    let from_above = |r: &mut SplitMix64, low: DVec3, high: DVec3| {
        let to = low + DVec3::new(r.unit(), 1.0, r.unit()) * (high - low);
        let from = to + DVec3::new(r.unit() - 0.5, 1.0 + r.unit(), r.unit() - 0.5);
        Ray::new(from, (to - from).normalize())
    };
    const NOTHING_LEFT: &str = "difference { box { 0, 1 } box { 0, 1 } }";
    const SPECKS: &str = "specks on a box less itself";
    let same = scene(&format!("object {{ {NOTHING_LEFT} pigment {{ rgb 1 }} }}"));
    let aim = |r: &mut SplitMix64| from_above(r, DVec3::ZERO, DVec3::ONE);
    let seen = total(n, 22, |r| u64::from(intersect(&same, &aim(r), MIN_DEPTH, FAR, 0).is_some()));
    // POV-Ray shows such a face; what matters is that it does so everywhere.
    report.cpu(SPECKS, seen.min(n - seen) as f64, 0.0, n);
    if let Some(traced) = report.povray(NOTHING_LEFT, n, 22, |r| (aim(r), ())) {
        let (of, seen) = (traced.len(), traced.iter().filter(|t| t.2.is_some()).count());
        report.povray_figure(SPECKS, seen.min(of - seen) as f64, of as u64);
    }
    let lid = scene("difference { box { 0, 1 } box { <0.25,0.5,0.25>, <0.75,1,0.75> } pigment { rgb 1 } }");
    let above = total(n, 23, |r| {
        let ray = from_above(r, DVec3::new(0.26, 0.0, 0.26), DVec3::new(0.74, 1.0, 0.74));
        let hit = intersect(&lid, &ray, MIN_DEPTH, FAR, 0);
        u64::from(hit.is_none_or(|h| {
            h.point.y > 0.9999 && (0.2500001..0.7499999).contains(&h.point.x) && (0.2500001..0.7499999).contains(&h.point.z)
        }))
    });
    report.cpu("specks on the lid of a hole that ends in it", above.min(n - above) as f64, 0.0, n);
    for kind in ["union", "merge"] {
        let both = scene(&format!("{kind} {{ box {{ 0, <2,1,1> pigment {{ rgb 1 }} }} box {{ <1,0,0>, <3,1,1> pigment {{ rgb 0 }} }} }}"));
        let first = |r: &mut SplitMix64| {
            let ray = from_above(r, DVec3::new(1.0, 0.0, 0.0), DVec3::new(2.0, 1.0, 1.0));
            intersect(&both, &ray, MIN_DEPTH, FAR, 0).map_or(u32::MAX, |h| h.prim_ix)
        };
        let n_first = total(n, 24, |r| u64::from(first(r) == 0));
        report.cpu(format!("minority winner of a face that two boxes share, {kind}"), n_first.min(n - n_first) as f64, 0.0, n);
    }
}

pub(super) fn nested(report: &mut Report) {
    let shells: String =
        (1..=20).map(|k| format!("sphere {{ 0, {} pigment {{ rgbt 1 }} interior {{ ior 1.5 }} }} ", f64::from(k) * 0.05)).collect();
    let scene = scene(&shells);
    let n = report.rays(100);
    for (name, near) in [("random", 1.0), ("through the middle", 1e-9)] {
        let wrong = total(n, 25, |r| {
            let from = 5.0 * r.direction();
            let dir = (near * r.cube() - from).normalize();
            let (mut inside, mut deepest, mut t, mut hits) = (0i64, 0, 0.0, 0);
            let mut from = from;
            while let Some(hit) = intersect(&scene, &Ray::new(from, dir), if hits == 0 { 0.0 } else { MIN_DEPTH }, FAR, 0) {
                inside += if hit.normal.dot(dir) < 0.0 { 1 } else { -1 };
                deepest = deepest.max(inside);
                (from, t, hits) = (hit.point, t + hit.t, hits + 1);
                if inside < 0 || hits > 100 {
                    return 1;
                }
            }
            u64::from(inside != 0 || (near < 0.5 && deepest != 20))
        });
        report.cpu(format!("rays whose ways in and out differ, {name}"), wrong as f64, 0.0, n);
    }
}

pub(super) fn instances(report: &mut Report) {
    let n = report.rays(100);
    // Numbers that 32-bit coordinates hold exactly: only the way of the ray differs.
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(2.0, 1.0, 0.0), DVec3::new(0.0, 0.5, 1.0));
    let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    let scale = |s: f64| DMat3::from_diagonal(DVec3::splat(s));
    let mut deep = DMat3::IDENTITY;
    (0..8).for_each(|k| deep *= if k % 2 == 0 { DMat3::from_diagonal(DVec3::new(2.0, 1.0, 0.5)) } else { mirror * scale(0.5) });
    let maps = [
        ("scale 2^-13", scale(1.0 / 8192.0)),
        ("scale 2^13", scale(8192.0)),
        ("shear", shear),
        ("mirror", mirror),
        ("8 in each other", deep),
    ];
    let on_lattice = |p: DVec3| (p * 4096.0).round() / 4096.0;
    for (what, mesh) in [("ball", ball(4, true, 1.0).mapped(on_lattice)), ("terrain", terrain(50).mapped(on_lattice))] {
        let shared = Arc::new(Mesh { vertices: mesh.vertices.clone(), faces: mesh.faces.clone(), ..Mesh::default() });
        for (name, m) in maps {
            let mut object = Object::new(Shape::Mesh(shared.clone()));
            object.transform = Transform::from_affine(DAffine3::from_mat3(m)).expect("a matrix with an inverse");
            let placed = compiled(&Scene { objects: vec![object], ..Scene::default() }, AccelKind::Auto);
            let flattened = mesh_scene(&mesh.clone().mapped(|p| m * p), AccelKind::Auto);
            let apart = largest(n, 26, |r| {
                // Not edge on, where the depth itself is ill-conditioned.
                let from = m * (6.0 * r.direction());
                let dir = (m * (0.8 * r.cube()) - from).normalize();
                let ray = Ray::new(from, dir);
                let (a, b) = (intersect(&placed, &ray, 0.0, FAR, 0), intersect(&flattened, &ray, 0.0, FAR, 0));
                match (a, b) {
                    (Some(a), Some(b)) if b.normal.dot(dir).abs() > 0.2 => (a.t - b.t).abs() / b.t.max(from.length()) / f64::EPSILON,
                    (Some(_), Some(_)) | (None, None) => 0.0,
                    // Only at the rim may one be met and the other not.
                    (a, b) => a.or(b).map_or(0.0, |h| if h.normal.dot(dir).abs() < 0.1 { 0.0 } else { f64::INFINITY }),
                }
            });
            report.cpu(format!("largest difference of depth in units in the last place, {what}, {name}"), apart, 16.0, n);
        }
    }
}
