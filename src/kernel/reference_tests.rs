//! Shapes against numbers that POV-Ray 3.7.0.10 printed for them (spec/objects_tests/t1, t3, t8, t10): `trace()`, `inside()`, extents.

use super::query::KernelQuery;
use crate::math::{DVec2, DVec3, DVec4, Ray, Transform, Vec3};
use crate::scene::shape::{BlobComponent, BlobKind, CurveKind, HeightGrid, JuliaFunction, SweepKind};
use crate::scene::{Csg, Mesh, Object, SceneQuery, Shape};
use std::sync::Arc;

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn points(list: &[(f64, f64)]) -> Vec<DVec2> {
    list.iter().map(|(x, y)| DVec2::new(*x, *y)).collect()
}

fn object(shape: Shape) -> Object {
    Object::new(shape)
}

fn sphere(center: DVec3, radius: f64) -> Object {
    object(Shape::Sphere { center, radius })
}

fn cube(half: f64) -> Object {
    object(Shape::Box { min: DVec3::splat(-half), max: DVec3::splat(half) })
}

fn plane(normal: DVec3, distance: f64) -> Object {
    object(Shape::Plane { normal: normal.normalize(), distance })
}

fn csg(op: Csg, children: Vec<Object>) -> Object {
    object(Shape::Csg { op, children })
}

fn inverse(mut o: Object) -> Object {
    o.flags.inverse = true;
    o
}

fn clipped(mut o: Object, by: Object) -> Object {
    o.clipped_by.push(by);
    o
}

fn moved(mut o: Object, steps: &[Transform]) -> Object {
    steps.iter().for_each(|t| o.apply_transform(t));
    o
}

/// Point and normal, or zeros for a miss, as POV-Ray prints them.
#[track_caller]
fn traces(o: &Object, from: DVec3, dir: DVec3, point: DVec3, normal: DVec3) {
    traces_to(o, from, dir, point, normal, 1e-9);
}

#[track_caller]
fn traces_to(o: &Object, from: DVec3, dir: DVec3, point: DVec3, normal: DVec3, slack: f64) {
    let ray = Ray::new(from, dir.normalize());
    let (p, n) = KernelQuery::new().trace(&Arc::new(o.clone()), &ray).unwrap_or_default();
    assert!((p - point).length() < slack && (n - normal).length() < slack.max(2e-6), "point {p} normal {n}, POV-Ray: {point} {normal}");
}

#[track_caller]
fn misses(o: &Object, from: DVec3, dir: DVec3) {
    traces(o, from, dir, DVec3::ZERO, DVec3::ZERO);
}

#[track_caller]
fn inside(o: &Object, p: DVec3, want: bool) {
    assert_eq!(KernelQuery::new().inside(&Arc::new(o.clone()), p), Some(want));
}

#[track_caller]
fn extends(o: &Object, min: DVec3, max: DVec3) {
    let b = KernelQuery::new().extent(&Arc::new(o.clone()));
    assert!((b.min - min).length() < 1e-6 && (b.max - max).length() < 1e-6, "{b:?}, POV-Ray: {min} {max}");
}

const Z5: DVec3 = DVec3::new(0.0, 0.0, -5.0);

#[test]
fn sphere_box_plane_disc() {
    let s = sphere(v(1.0, 2.0, 3.0), 2.0);
    traces(
        &s,
        v(0.0, 0.0, -10.0),
        v(0.1, 0.2, 1.3),
        v(0.848380391284, 1.696760782568, 1.028945086695),
        v(-0.075809804358, -0.151619608716, -0.985527456653),
    );
    inside(&s, v(3.0, 2.0, 3.0), false);
    traces(&s, v(1.0, 2.0, 3.0), DVec3::X, v(3.0, 2.0, 3.0), DVec3::X);
    let si = inverse(sphere(DVec3::ZERO, 1.0));
    traces(&si, Z5, DVec3::Z, v(0.0, 0.0, -1.0), DVec3::Z);
    inside(&si, DVec3::ZERO, false);
    let b = cube(1.0);
    inside(&b, DVec3::X, true);
    traces(&b, v(0.2, 0.3, -5.0), DVec3::Z, v(0.2, 0.3, -1.0), -DVec3::Z);
    traces(&b, DVec3::splat(-5.0), DVec3::ONE, DVec3::splat(-1.0), -DVec3::X);
    let p = plane(2.0 * DVec3::Y, 3.0);
    traces(&p, v(1.0, 10.0, 2.0), v(1.0, -1.0, 0.0), v(8.0, 3.0, 2.0), DVec3::Y);
    inside(&p, v(0.0, 3.0, 0.0), true);
    inside(&p, v(0.0, 4.0, 0.0), false);
    let d = object(Shape::Disc { center: DVec3::Y, normal: DVec3::Y, radius: 2.0, hole: 0.5 });
    traces(&d, v(1.0, 5.0, 0.0), -DVec3::Y, v(1.0, 1.0, 0.0), DVec3::Y);
    misses(&d, v(0.1, 5.0, 0.0), -DVec3::Y);
    inside(&d, v(5.0, 0.0, 5.0), true);
    inside(&d, v(0.0, 2.0, 0.0), false);
    traces(&sphere(DVec3::ZERO, 1.0), v(0.0, 0.0, -1.00005), DVec3::Z, DVec3::Z, DVec3::Z);
    traces(&sphere(DVec3::ZERO, 1.0), v(0.0, 0.0, -1.0002), DVec3::Z, -DVec3::Z, -DVec3::Z);
}

#[test]
fn cylinder_and_cone() {
    let cylinder = |open| object(Shape::Cylinder { a: DVec3::ZERO, b: 2.0 * DVec3::Y, radius: 0.5, open });
    let c = cylinder(false);
    inside(&c, v(0.5, 1.0, 0.0), false);
    inside(&c, v(0.0, 2.0, 0.0), false);
    traces(&c, v(0.1, 5.0, 0.2), -DVec3::Y, v(0.1, 2.0, 0.2), DVec3::Y);
    let o = cylinder(true);
    inside(&o, v(0.5, 1.0, 0.0), true);
    inside(&o, v(0.0, 2.0, 0.0), true);
    misses(&o, v(0.1, 5.0, 0.2), v(0.05, -1.0, 0.0));
    let k = object(Shape::Cone { a: DVec3::ZERO, radius_a: 1.0, b: 2.0 * DVec3::Y, radius_b: 0.3, open: false });
    traces(&k, v(0.1, 1.0, -5.0), DVec3::Z, v(0.1, 1.0, -0.642261628933), v(0.145208977902, 0.330350424728, -0.932621546834));
    inside(&k, v(0.0, 1.0, 0.64), true);
    inside(&k, v(0.0, 1.0, 0.66), false);
    let scaled = moved(
        object(Shape::Cylinder { a: DVec3::ZERO, b: 2.0 * DVec3::Y, radius: 1.0, open: false }),
        &[Transform::scaling(v(1.0, 2.0, 3.0))],
    );
    traces_to(&scaled, v(0.2, 1.0, -10.0), DVec3::Z, v(0.2, 1.0, -2.939387691), v(0.522232968, 0.0, -0.852802865), 1e-8);
    let tip = object(Shape::Cone { a: DVec3::ZERO, radius_a: 0.0, b: DVec3::Y, radius_b: 1.0, open: false });
    let h = -std::f64::consts::FRAC_1_SQRT_2;
    traces(&tip, v(0.0, 0.5, -5.0), DVec3::Z, v(0.0, 0.5, -0.5), v(0.0, h, h));
}

#[test]
fn torus() {
    let t = object(Shape::Torus { major: 2.0, minor: 0.5 });
    let n = v(0.404125839159, 0.914518929751, 0.018369356325);
    traces(&t, v(2.2, 5.0, 0.1), -DVec3::Y, v(2.2, 0.457259464875, 0.1), n);
    traces(&t, v(-5.0, 0.1, 0.3), DVec3::X, v(-2.471758846293, 0.1, 0.3), v(-0.972658006990, 0.2, 0.118052536773));
    let turned = moved(object(Shape::Torus { major: 1.0, minor: 0.2 }), &[Transform::rotation_deg(v(30.0, 0.0, 0.0))]);
    extends(&turned, v(-1.2, -0.773205101490, -1.139230489731), v(1.2, 0.773205101490, 1.139230489731));
}

#[test]
fn quadric_and_polynomials() {
    // A B C, then D E F = xy xz yz, then G H I, J.
    let q = object(Shape::Quadric { coefficients: [1.0, 2.0, 3.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, -4.0] });
    traces(
        &q,
        Z5,
        v(0.1, 0.05, 1.0),
        v(0.378606000189, 0.189303000095, -1.213939998106),
        v(0.139672711114, 0.139304028364, -0.980349897461),
    );
    inside(&q, DVec3::ZERO, true);
    let mut c: Vec<f64> = (1..=20).map(f64::from).collect();
    c[19] = -20.0;
    let cubic = object(Shape::Poly { order: 3, coefficients: c });
    traces(&cubic, v(0.3, 0.4, 5.0), -DVec3::Z, v(0.3, 0.4, 0.175796388963), v(0.317586530326, 0.661447553688, 0.679430592095));
    inside(&cubic, DVec3::ZERO, true);
    let mut c: Vec<f64> = (1..=35).map(f64::from).collect();
    c[34] = -35.0;
    let quartic = object(Shape::Poly { order: 4, coefficients: c });
    traces(&quartic, v(0.3, 0.4, 5.0), -DVec3::Z, v(0.3, 0.4, 0.101164319854), v(0.354584665125, 0.709482264645, 0.609019401508));
    traces(&quartic, v(5.0, 0.1, -0.2), -DVec3::X, v(1.109218018502, 0.1, -0.2), v(0.581051392211, 0.598187545647, 0.551861341137));
    let poly = |order: usize, terms: &[([usize; 3], f64)]| {
        let mut coefficients = Vec::new();
        for x in (0..=order).rev() {
            for y in (0..=order - x).rev() {
                for z in (0..=order - x - y).rev() {
                    coefficients.push(terms.iter().find(|t| t.0 == [x, y, z]).map_or(0.0, |t| t.1));
                }
            }
        }
        object(Shape::Poly { order: order as u32, coefficients })
    };
    let p3 = poly(3, &[([2, 1, 0], 1.5), ([0, 0, 3], 2.0), ([0, 0, 0], -1.0), ([1, 0, 1], 0.7)]);
    traces(&p3, v(0.5, 0.6, 5.0), -DVec3::Z, v(0.5, 0.6, 0.649392916152), v(0.422656430516, 0.117008033228, 0.898704991587));
    let p5 = poly(5, &[([5, 0, 0], 1.0), ([0, 3, 1], 2.0), ([0, 0, 2], 3.0), ([0, 0, 0], -1.0)]);
    traces(&p5, v(0.5, 0.6, 5.0), -DVec3::Z, v(0.5, 0.6, 0.500800721601), v(0.086408366254, 0.299105548456, 0.950299671222));
}

#[test]
fn superellipsoid() {
    let s = object(Shape::Superellipsoid { e: 0.4, n: 1.7 });
    traces(&s, v(0.3, 0.2, -5.0), DVec3::Z, v(0.3, 0.2, -0.783302432738), v(0.604735579972, 0.119453941723, -0.787417064917));
    traces(&s, v(-5.0, 0.3, 0.1), DVec3::X, v(-0.942477319358, 0.3, 0.1), v(-0.828908519941, 0.008509577374, 0.559319454929));
    let n = v(-0.765010556685, -0.044317378268, 0.642491103552);
    traces(&s, v(-5.0, -4.0, 0.1), v(5.0, 4.3, 0.2), v(-0.812125574836, -0.398427994359, 0.267514977007), n);
    inside(&s, DVec3::splat(0.5), true);
}

fn ball(x: f64, y: f64, z: f64, radius: f64, strength: f64) -> BlobComponent {
    BlobComponent { kind: BlobKind::Sphere { center: v(x, y, z), radius }, strength, transform: Transform::IDENTITY, texture: None }
}

#[test]
fn blob() {
    let rod = BlobKind::Cylinder { a: v(0.0, -1.0, 0.0), b: v(0.0, 1.0, 0.2), radius: 0.5 };
    let rod = BlobComponent { kind: rod, strength: 0.7, transform: Transform::IDENTITY, texture: None };
    let components = vec![ball(0.5, 0.0, 0.0, 1.2, 1.0), ball(-0.4, 0.1, 0.0, 1.0, 0.8), rod];
    let b = object(Shape::Blob { threshold: 0.6, components });
    traces(&b, v(0.1, 0.05, -5.0), DVec3::Z, v(0.1, 0.05, -0.559273283748), v(-0.026839279344, 0.012911261149, -0.999556377810));
    traces(&b, v(0.1, 5.0, 0.0), -DVec3::Y, v(0.1, 0.887358594396, 0.0), v(0.323863261858, 0.583346359537, -0.744862143241));
    inside(&b, v(0.0, 0.0, 0.6), false);
    let one = object(Shape::Blob { threshold: 0.5, components: vec![ball(0.0, 0.0, 0.0, 1.0, 1.0)] });
    traces_to(&one, v(0.0, 0.0, -0.55), DVec3::Z, v(0.0, 0.0, 0.5411961), DVec3::Z, 1e-8);
    traces_to(&one, v(0.0, 0.0, -0.57), DVec3::Z, v(0.0, 0.0, -0.5411961), -DVec3::Z, 1e-8);
}

#[test]
fn lathes() {
    let lathe = |kind, list: &[(f64, f64)]| object(Shape::Lathe { kind, points: points(list) });
    let l = lathe(CurveKind::Linear, &[(0.0, 0.0), (1.0, 0.2), (0.8, 1.0), (0.0, 1.2)]);
    traces(&l, v(0.1, 0.5, -5.0), DVec3::Z, v(0.1, 0.5, -0.919578707887), v(0.104880270286, 0.242535625036, -0.964456634325));
    traces(&l, v(0.3, 5.0, 0.1), -DVec3::Y, v(0.3, 1.120943058496, 0.1), v(0.230089496654, 0.970142500145, 0.076696498885));
    inside(&l, v(0.5, 0.5, 0.0), true);
    inside(&l, v(0.99, 0.2, 0.0), false);
    let five = [(0.0, -0.5), (0.4, 0.0), (1.0, 0.4), (0.8, 1.0), (0.3, 1.2)];
    let q = lathe(CurveKind::Quadratic, &five);
    // Exactly -1.0187852468: POV-Ray's solver is a little off.
    let n = v(0.097333214917, -0.084988762352, -0.991616435699);
    traces_to(&q, v(0.1, 0.5, -5.0), DVec3::Z, v(0.1, 0.5, -1.018785248742), n, 5e-9);
    let six = [five[0], five[1], five[2], five[3], five[4], (0.2, 1.5)];
    let c = lathe(CurveKind::Cubic, &six);
    traces(&c, v(0.1, 0.5, -5.0), DVec3::Z, v(0.1, 0.5, -1.011483897510), v(0.098377325833, 0.012489421304, -0.995070809600));
    let b = lathe(CurveKind::Bezier, &[(0.2, 0.0), (1.4, 0.2), (0.6, 1.0), (0.5, 1.2)]);
    traces(&b, v(0.1, 0.5, -5.0), DVec3::Z, v(0.1, 0.5, -0.847170536422), v(0.117065315618, 0.052362266766, -0.991742862288));
    // A ray that is not level goes another way through the solver: the same surface must come out.
    let tilted = Ray::new(v(0.1, 0.5 + 1e-3, -5.0), v(0.0, -1e-3 / 4.080421292113, 1.0).normalize());
    let (p, _) = KernelQuery::new().trace(&Arc::new(l), &tilted).expect("a hit");
    assert!((p - v(0.1, 0.5, -0.919578707887)).length() < 1e-6, "{p}");
}

#[test]
fn surface_of_revolution() {
    let s = object(Shape::Sor { points: points(&[(0.0, -0.5), (0.4, 0.0), (1.0, 0.4), (0.8, 1.0), (0.3, 1.2)]), open: false });
    traces(&s, v(0.1, 0.5, -5.0), DVec3::Z, v(0.1, 0.5, -1.018986424509), v(0.097278468737, -0.089171929675, -0.991254390395));
    traces(&s, v(0.1, -5.0, 0.0), DVec3::Y, v(0.1, 0.0, 0.0), -DVec3::Y);
    inside(&s, v(0.5, 0.5, 0.0), true);
    traces(&s, v(0.1, 5.0, 0.0), -DVec3::Y, v(0.1, 1.0, 0.0), DVec3::Y);
}

#[test]
fn prisms() {
    let prism =
        |kind, conic, low, list: &[(f64, f64)]| object(Shape::Prism { kind, conic, low, high: 1.0, points: points(list), open: false });
    let p = prism(CurveKind::Linear, false, 0.0, &[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)]);
    traces(&p, v(0.3, 0.4, -5.0), DVec3::Z, v(0.3, 0.4, 0.0), -DVec3::Z);
    traces(&p, v(0.3, 5.0, 0.4), -DVec3::Y, v(0.3, 1.0, 0.4), DVec3::Y);
    traces(&p, v(0.3, -5.0, 0.4), DVec3::Y, v(0.3, 0.0, 0.4), DVec3::Y);
    inside(&p, v(0.5, 0.0, 0.5), true);
    inside(&p, v(0.5, 1.0, 0.5), false);
    traces(&p, v(5.0, 0.4, 0.3), -DVec3::X, v(1.0, 0.4, 0.3), DVec3::X);
    let c = prism(CurveKind::Linear, true, 0.5, &[(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)]);
    let h = -std::f64::consts::FRAC_1_SQRT_2;
    traces(&c, v(0.3, 0.7, -5.0), DVec3::Z, v(0.3, 0.7, -0.7), v(0.0, h, h));
    inside(&c, v(0.6, 0.7, 0.0), true);
    inside(&c, v(0.8, 0.7, 0.0), false);
    let q = prism(
        CurveKind::Quadratic,
        false,
        0.0,
        &[(-1.0, -1.0), (1.0, -1.0), (1.5, 0.0), (1.0, 1.0), (-1.0, 1.0), (-1.2, 0.0), (1.0, -1.0)],
    );
    traces(&q, v(5.0, 0.5, 0.2), -DVec3::X, v(1.48, 0.5, 0.2), v(0.980580675691, 0.0, 0.196116135138));
    let cu =
        prism(CurveKind::Cubic, false, 0.0, &[(-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]);
    traces(&cu, v(5.0, 0.5, 0.2), -DVec3::X, v(1.243533263179, 0.5, 0.2), v(0.997871697628, 0.0, 0.065207937200));
    let b = prism(
        CurveKind::Bezier,
        false,
        0.0,
        &[(-1.0, 0.0), (-1.0, 2.0), (1.0, 2.0), (1.0, 0.0), (1.0, 0.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 0.0)],
    );
    traces(&b, v(0.3, 0.5, -5.0), DVec3::Z, v(0.3, 0.5, -0.719160387840), v(0.206899295699, 0.0, -0.978362244488));
    traces(&b, v(0.3, 0.5, 5.0), -DVec3::Z, v(0.3, 0.5, 1.438320775679), v(0.389541062192, 0.0, 0.921009099231));
}

#[test]
fn polygon_triangles_and_meshes() {
    let square = |a: f64, b: f64| [v(a, a, 0.0), v(b, a, 0.0), v(b, b, 0.0), v(a, b, 0.0), v(a, a, 0.0)];
    let pg = object(Shape::Polygon { points: square(0.0, 4.0).into_iter().chain(square(1.0, 3.0)).collect() });
    traces(&pg, v(0.5, 0.5, -5.0), DVec3::Z, v(0.5, 0.5, 0.0), DVec3::Z);
    misses(&pg, v(2.0, 2.0, -5.0), DVec3::Z);
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let t = object(Shape::Triangle { vertices: corners, normals: None });
    traces(&t, v(0.2, 0.2, -5.0), DVec3::Z, v(0.2, 0.2, 0.0), -DVec3::Z);
    traces(&t, v(0.2, 0.2, 5.0), -DVec3::Z, v(0.2, 0.2, 0.0), -DVec3::Z);
    let s = object(Shape::Triangle { vertices: corners, normals: Some([v(-1.0, 0.0, -1.0), v(1.0, 0.0, -1.0), v(0.0, 1.0, -1.0)]) });
    traces(&s, v(0.2, 0.3, -5.0), DVec3::Z, v(0.2, 0.3, 0.0), v(-0.276172385369, 0.276172385369, -0.920574617898));
    let normals = [Vec3::splat(-1.0), Vec3::X, Vec3::Y, Vec3::Z].map(Vec3::normalize).to_vec();
    let faces = vec![[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];
    let vertices = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let mut mesh = Mesh { vertices, normals, normal_indices: faces.clone(), faces, ..Mesh::default() };
    mesh.inside_vector = Some(v(0.3, 0.4, 1.0));
    let m = object(Shape::Mesh(Arc::new(mesh)));
    let n = v(-0.293432022662, 0.037474688720, -0.955245149573);
    traces(&m, v(0.2, 0.3, -5.0), DVec3::Z, v(0.2, 0.3, 0.0), n);
    let n = v(0.628195247457, 0.459065813839, 0.628195279859);
    traces(&m, DVec3::splat(5.0), v(-4.7, -4.8, -4.7), v(0.366197183099, 0.267605633803, 0.366197183099), n);
    inside(&m, DVec3::splat(0.1), true);
    inside(&m, DVec3::ONE, false);
    let flat = Mesh { vertices: vec![Vec3::ZERO, Vec3::X, Vec3::Y], faces: vec![[0, 1, 2]], ..Mesh::default() };
    let f = clipped(object(Shape::Mesh(Arc::new(flat))), plane(DVec3::X, 0.1));
    misses(&f, v(0.2, 0.3, -5.0), DVec3::Z);
    traces(&f, v(0.05, 0.3, -5.0), DVec3::Z, v(0.05, 0.3, 0.0), -DVec3::Z);
    assert_eq!(KernelQuery::new().inside(&Arc::new(pg), DVec3::ZERO), None);
}

#[test]
fn csg_and_coincident_faces() {
    let pair = || vec![sphere(DVec3::ZERO, 1.0), sphere(v(0.5, 0.0, 0.0), 1.0)];
    let from = v(0.4, 0.0, 0.0);
    traces(&csg(Csg::Union, pair()), from, DVec3::X, DVec3::X, DVec3::X);
    traces(&csg(Csg::Merge, pair()), from, DVec3::X, v(1.5, 0.0, 0.0), DVec3::X);
    let i = csg(Csg::Intersection, pair());
    traces(&i, from, DVec3::X, DVec3::X, DVec3::X);
    extends(&i, v(-0.5, -1.0, -1.0), DVec3::ONE);
    let d = csg(Csg::Difference, vec![cube(1.0), sphere(-DVec3::Z, 0.5)]);
    traces(&d, v(0.1, 0.0, -5.0), DVec3::Z, v(0.1, 0.0, -0.510102051443), v(-0.2, 0.0, -0.979795897113));
    inside(&d, v(0.0, 0.0, -0.8), false);
    extends(&d, DVec3::splat(-1.0), DVec3::ONE);
    let notch = object(Shape::Box { min: v(-0.5, -0.5, -1.0), max: v(0.5, 0.5, 0.0) });
    traces(&csg(Csg::Difference, vec![cube(1.0), notch]), v(0.1, 0.1, -5.0), DVec3::Z, v(0.1, 0.1, -1.0), DVec3::Z);
    let drill = object(Shape::Cylinder { a: -DVec3::Z, b: DVec3::Z, radius: 0.5, open: false });
    let d3 = csg(Csg::Difference, vec![cube(1.0), drill]);
    traces(&d3, v(0.1, 0.1, -5.0), DVec3::Z, v(0.1, 0.1, -1.0), DVec3::Z);
    traces(&d3, v(0.7, 0.1, -5.0), DVec3::Z, v(0.7, 0.1, -1.0), -DVec3::Z);
    let d4 = csg(Csg::Difference, vec![sphere(DVec3::ZERO, 1.0), plane(-DVec3::Z, 0.0)]);
    traces(&d4, v(0.1, 0.1, -5.0), DVec3::Z, v(0.1, 0.1, -0.989949493661), v(0.1, 0.1, -0.989949493661));
    traces(&d4, v(0.1, 0.1, 5.0), -DVec3::Z, v(0.1, 0.1, 0.0), DVec3::Z);
    let iu = inverse(csg(Csg::Union, vec![sphere(DVec3::ZERO, 1.0), cube(0.5)]));
    inside(&iu, DVec3::ZERO, false);
    inside(&iu, DVec3::splat(3.0), true);
    traces(&iu, v(0.0, 0.1, -5.0), DVec3::Z, v(0.0, 0.1, -0.994987437107), v(0.0, -0.1, 0.994987437107));
    let slab = csg(Csg::Difference, vec![plane(DVec3::Y, 1.0), plane(DVec3::Y, 0.0)]);
    inside(&slab, v(0.0, 0.5, 0.0), true);
    inside(&slab, v(0.0, -0.5, 0.0), false);
    traces(&slab, v(0.0, 5.0, 0.0), -DVec3::Y, DVec3::Y, DVec3::Y);
    traces(&slab, v(0.0, -5.0, 0.0), DVec3::Y, DVec3::ZERO, -DVec3::Y);
}

#[test]
fn clips_bounds_and_transforms() {
    let c = clipped(sphere(DVec3::ZERO, 1.0), plane(DVec3::Y, 0.0));
    traces(&c, 5.0 * DVec3::Y, -DVec3::Y, -DVec3::Y, -DVec3::Y);
    inside(&c, v(0.0, -0.5, 0.0), true);
    inside(&c, v(0.0, 0.5, 0.0), false);
    extends(&c, DVec3::splat(-1.0), DVec3::ONE);
    let mut b = sphere(DVec3::ZERO, 1.0);
    b.bounded_by.push(cube(0.5));
    traces(&b, Z5, DVec3::Z, -DVec3::Z, -DVec3::Z);
    misses(&b, v(0.7, 0.0, -5.0), DVec3::Z);
    inside(&b, v(0.7, 0.0, 0.0), true);
    extends(&b, DVec3::splat(-0.5), DVec3::splat(0.5));
    let e = moved(
        sphere(DVec3::ZERO, 1.0),
        &[Transform::scaling(v(1.0, 2.0, 3.0)), Transform::rotation_deg(v(10.0, 20.0, 30.0)), Transform::translation(v(1.0, 2.0, 3.0))],
    );
    traces(&e, v(0.5, 1.5, -10.0), DVec3::Z, v(0.5, 1.5, 0.296024406215), v(0.426842132791, -0.041662273710, -0.903365954984));
    extends(&e, v(-1.831303834915, -0.289059489965, -0.444621711969), v(3.831303834915, 4.289059162140, 6.444622039795));
    let m = Transform::from_rows([1.0, 0.2, 0.0, 0.3, 1.0, 0.0, 0.0, 0.1, 1.0, 1.0, 2.0, 3.0]).expect("can be inverted");
    let m = moved(sphere(DVec3::ZERO, 1.0), &[m]);
    traces(&m, v(1.0, 2.0, -10.0), DVec3::Z, v(1.0, 2.0, 2.006111464265), v(-0.055401492004, 0.120775252568, -0.991132691949));
    let r = moved(sphere(DVec3::X, 0.2), &[Transform::rotation_deg(v(0.0, 90.0, 0.0))]);
    traces(&r, Z5, DVec3::Z, v(0.0, 0.0, -1.2), -DVec3::Z);
    let turns = [Transform::scaling(DVec3::splat(2.0)), Transform::rotation_deg(v(0.0, 0.0, 30.0)), Transform::translation(DVec3::X)];
    traces_to(&moved(plane(DVec3::Y, 1.0), &turns), 10.0 * DVec3::Y, -DVec3::Y, v(0.0, 1.732050808, 0.0), v(-0.5, 0.866025404, 0.0), 1e-8);
    extends(&object(Shape::Quadric { coefficients: [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0] }), -DVec3::ONE, DVec3::ONE);
}

#[test]
fn bicubic_patch() {
    let rows = [
        [(0.0, 0.0, 0.0), (1.0, 0.0, 1.0), (2.0, 0.0, 1.0), (3.0, 0.0, 0.0)],
        [(0.0, 1.0, 0.0), (1.0, 1.0, 2.0), (2.0, 1.0, 2.0), (3.0, 1.0, 0.0)],
        [(0.0, 2.0, 0.0), (1.0, 2.0, 2.0), (2.0, 2.0, 2.0), (3.0, 2.0, 0.0)],
        [(0.0, 3.0, 0.0), (1.0, 3.0, 1.0), (2.0, 3.0, 1.0), (3.0, 3.0, 0.0)],
    ];
    let p = Box::new(rows.map(|r| r.map(|(x, y, z)| v(x, y, z))));
    let uvs = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
    let patch = object(Shape::BicubicPatch { points: p, uvs, flatness: 0.01, u_steps: 3, v_steps: 3, accuracy: 0.01 });
    let clipped = clipped(patch.clone(), plane(DVec3::X, 1.0));
    for o in [patch, clipped] {
        let n = v(0.218244415571, -0.099103574713, -0.970849039012);
        traces_to(&o, v(1.3, 1.7, -5.0), DVec3::Z, v(1.3, 1.7, 1.250146484375), n, 1e-6);
        let n = v(0.769105419215, 0.087688324376, -0.633077887705);
        traces_to(&o, v(0.31, 0.72, -5.0), DVec3::Z, v(0.31, 0.72, 0.423828125), n, 1e-6);
    }
}

#[test]
fn height_fields() {
    // `function 5,4 {f}` stored as 16 bits; z = 0 is the last row, y = 1.
    let field = |f: fn(f64, f64) -> f64, water_level: f64, smooth: bool| {
        let mut heights = Vec::new();
        for j in 0..4 {
            for i in 0..5 {
                heights.push((f(f64::from(i) / 4.0, 1.0 - f64::from(j) / 3.0) * 65535.0) as u16);
            }
        }
        object(Shape::HeightField { heights: Arc::new(HeightGrid { width: 5, height: 4, heights }), water_level, smooth })
    };
    let hf = field(|x, y| x * 0.5 + y * 0.25, 0.0, false);
    let n = v(-0.436437048911, 0.872874097823, 0.218205205454);
    let down = -DVec3::Y;
    // Heights are cut to whole numbers: a unit more or less is 1.5e-5.
    traces_to(&hf, v(0.33, 5.0, 0.4), down, v(0.33, 0.314990844727, 0.4), n, 2e-5);
    traces_to(&hf, v(0.8, 5.0, 0.9), down, v(0.8, 0.424983215332, 0.9), n, 2e-5);
    inside(&hf, v(0.5, 0.1, 0.5), true);
    inside(&hf, v(0.5, -3.0, 0.5), true);
    let smooth = field(|x, y| x * x * 0.5 + y * 0.25, 0.0, true);
    let n = v(-0.328142194393, 0.904272912057, 0.273154170348);
    traces_to(&smooth, v(0.33, 5.0, 0.4), down, v(0.33, 0.211240844727, 0.4), n, 5e-5);
    let water = field(|x, y| x * 0.5 + y * 0.25, 0.3, false);
    misses(&water, v(0.05, 5.0, 0.05), down);
    inside(&water, v(0.5, -3.0, 0.5), true);
}

#[test]
fn ovus() {
    let o = object(Shape::Ovus { bottom: 1.0, top: 0.6 });
    traces(&o, v(0.1, 5.0, 0.05), -DVec3::Y, v(0.1, 1.589491306128, 0.05), v(0.166666666667, 0.982485510213, 0.083333333333));
    traces(&o, v(0.1, -5.0, 0.05), DVec3::Y, v(0.1, -0.993730345718, 0.05), v(0.1, -0.993730345718, 0.05));
    traces(&o, v(0.1, 0.7, -5.0), DVec3::Z, v(0.1, 0.7, -0.875357454435), v(0.106739059564, 0.34, -0.934348314690));
    inside(&o, 0.2 * DVec3::Y, true);
    let o = object(Shape::Ovus { bottom: 1.0, top: 1.5 });
    traces(&o, v(0.1, 0.7, -5.0), DVec3::Z, v(0.1, 0.7, -1.466287829862), v(0.066666666667, -0.2, -0.977525219908));
}

#[test]
fn sphere_sweeps() {
    let sweep = |kind, list: &[(f64, f64, f64, f64)]| {
        object(Shape::SphereSweep { kind, spheres: list.iter().map(|s| (v(s.0, s.1, s.2), s.3)).collect(), tolerance: 1e-6 })
    };
    let five = [(0.0, 0.0, 0.0, 0.5), (2.0, 0.0, 0.0, 0.3), (2.0, 2.0, 0.0, 0.2), (0.0, 3.0, 0.0, 0.3), (0.0, 4.0, 1.0, 0.3)];
    let linear = sweep(SweepKind::Linear, &five[..3]);
    traces(&linear, v(1.0, 0.05, -5.0), DVec3::Z, v(1.0, 0.05, -0.398893672068), v(0.1, 0.12375, -0.987261838369));
    inside(&linear, v(1.0, 0.3, 0.0), true);
    let cubic = sweep(SweepKind::Cubic, &five);
    traces(&cubic, v(2.1, 1.0, -5.0), DVec3::Z, v(2.1, 1.0, -0.172925386397), v(-0.653569445235, 0.033043829367, -0.756144883998));
    misses(&cubic, v(1.0, 0.0, -5.0), DVec3::Z);
    let spline = sweep(SweepKind::BSpline, &five);
    traces(&spline, v(1.9, 1.0, -5.0), DVec3::Z, v(1.9, 1.0, -0.257278806711), v(-0.062649975238, 0.057998546150, -0.996348909392));
    let deep = sweep(SweepKind::Linear, &[(0.0, 0.0, 0.0, 5.0), (1.0, 0.0, 0.0, 5.0)]);
    inside(&deep, DVec3::ZERO, false);
    inside(&deep, v(0.5, 4.9, 0.0), false);
    inside(&deep, v(-3.0, 0.0, 0.0), false);
}

#[test]
fn julia_fractals() {
    let julia = |c, hypercomplex, function, max_iteration| {
        object(Shape::JuliaFractal { c, hypercomplex, function, max_iteration, precision: 15.0, slice: DVec4::W, slice_distance: 0.0 })
    };
    let q = julia(DVec4::new(-0.083, 0.0, -0.83, -0.025), false, JuliaFunction::Sqr, 8);
    let n = v(0.854707628309, 0.141787631672, -0.499370741650);
    traces_to(&q, v(0.1, 0.2, -5.0), DVec3::Z, v(0.1, 0.2, -0.341339583216), n, 2e-5);
    inside(&q, v(0.1, 0.2, 0.1), true);
    let h = julia(DVec4::new(0.1, 0.2, 0.3, 0.1), true, JuliaFunction::Exp, 6);
    inside(&h, v(0.1, 0.2, 0.9), false);
    inside(&h, v(0.1, 0.2, 0.2), false);
}
