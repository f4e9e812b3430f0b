//! Closed meshes do not leak: every ray from inside meets a face, as the kernel tests them.

use rayloom::accel::AccelKind;
use rayloom::bench::stability::leaks::meets_face;
use rayloom::bench::stability::meshes::{FAR_AWAY, Triangles, ball, tetrahedron};
use rayloom::compile::shape::MeshShape;
use rayloom::math::DVec3;
use rayloom::math::random::SplitMix64;
use rayloom::scene::Mesh;
use std::sync::Arc;

/// Rays of each kind: random, at vertices, at edges.
const N_RAYS: usize = 700_000;

/// Rays out of `mesh` that meet nothing; `near` is how far from the middle they may start.
fn leaks(mesh: &Triangles, kind: AccelKind, middle: DVec3, near: f64) -> [usize; 3] {
    let shape = Mesh { vertices: mesh.vertices.clone(), faces: mesh.faces.clone(), ..Mesh::default() };
    let shape = MeshShape::new(Arc::new(shape), Vec::new(), kind).expect("faces with vertices");
    let mut r = SplitMix64(37);
    let mut lost = [0; 3];
    // The two that are the defaults get all rays, the others enough to see that they keep faces.
    let n_rays = if matches!(kind, AccelKind::Kd | AccelKind::Bvh) { N_RAYS } else { N_RAYS / 8 };
    for _ in 0..n_rays {
        let from = middle + near * r.cube();
        let [a, b, _] = mesh.corners(r.below(mesh.faces.len()));
        let targets = [from + r.direction(), a, a + r.unit() * (b - a)];
        for (lost, to) in lost.iter_mut().zip(targets) {
            *lost += usize::from(!meets_face(&shape, from, (to - from).normalize()));
        }
    }
    lost
}

fn stays_tight(mesh: &Triangles, middle: DVec3, near: f64) {
    for kind in crate::TREES {
        assert_eq!(leaks(mesh, kind, middle, near), [0; 3], "{kind:?}: random, at vertices, at edges, of {N_RAYS} each");
    }
}

#[test]
fn a_ball_of_82k_faces_does_not_leak() {
    stays_tight(&ball(6, true, 2.0), DVec3::ZERO, 0.9);
}

#[test]
fn a_ball_far_from_the_origin_does_not_leak() {
    stays_tight(&ball(6, true, 2.0).mapped(|p| p + FAR_AWAY), FAR_AWAY, 0.9);
}

#[test]
fn tetrahedra_near_and_far_do_not_leak() {
    stays_tight(&tetrahedron(), DVec3::ZERO, 0.3);
    stays_tight(&tetrahedron().mapped(|p| p + FAR_AWAY), FAR_AWAY, 0.3);
}

#[test]
fn tiny_and_huge_balls_do_not_leak() {
    // POV-Ray's least and greatest depths (1e-6, 1e7) bound what can be hit.
    for scale in [1e-3, 1e6] {
        stays_tight(&ball(4, false, scale), DVec3::ZERO, 0.4 * scale);
    }
}

#[test]
fn a_missing_face_leaks() {
    let mut mesh = ball(4, true, 2.0);
    mesh.faces.swap_remove(1000);
    for kind in crate::TREES {
        let lost = leaks(&mesh, kind, DVec3::ZERO, 0.9);
        assert!(lost[0] > 10 && lost[1] > 0, "{lost:?}");
    }
}
