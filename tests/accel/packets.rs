//! Rays in packets find the hits of the same rays alone, to the last bit: depth, face and weights.

use rayloom::accel::{AccelKind, Packet};
use rayloom::bench::stability::meshes::*;
use rayloom::bench::stability::ray_source::RaySource;
use rayloom::compile::shape::MeshShape;
use rayloom::kernel::intersect::mesh::intersect_mesh;
use rayloom::kernel::intersect::mesh_packet::{PacketHits, intersect_mesh_packet};
use rayloom::kernel::intersect::{HitSink, LocalRay, Part};
use rayloom::math::random::SplitMix64;
use rayloom::math::{DVec3, Ray};
use rayloom::scene::Mesh;
use std::sync::Arc;

const N_PACKETS: usize = 3_000;

/// The nearest hit, or any.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Kept {
    far: f64,
    any: bool,
    hit: Option<(f64, Part)>,
}

impl HitSink for Kept {
    fn push(&mut self, t: f64, part: Part) {
        if t <= self.far {
            (self.far, self.hit) = (t, Some((t, part)));
        }
    }

    fn far(&self) -> f64 {
        if self.any && self.hit.is_some() { f64::NEG_INFINITY } else { self.far }
    }
}

/// Rays of a packet: those of the source as they come, or bundles around one of them, from one point, to one point or side by side.
fn packet(source: &mut RaySource, numbers: &mut SplitMix64, k: usize) -> Vec<Ray> {
    let n = [64, 64, 17, 8, 3, 1][numbers.below(6)];
    if k.is_multiple_of(4) {
        return source.take(n).collect();
    }
    let first = source.next().expect("rays without end");
    let spread = [0.0, 1e-9, 1e-3, 0.05, 0.5][numbers.below(5)];
    (0..n)
        .map(|_| {
            let (a, b) = (spread * numbers.direction(), spread * numbers.direction());
            let (from, to) = match k % 4 {
                1 => (first.origin, first.at(1.0) + b),
                2 => (first.origin + a, first.at(1.0)),
                _ => (first.origin + a, first.at(1.0) + a),
            };
            Ray::new(from, (to - from).try_normalize().unwrap_or(DVec3::X))
        })
        .collect()
}

fn alone(shape: &MeshShape, r: &Ray, far: f64, any: bool) -> Kept {
    let mut sink = Kept { far, any, hit: None };
    intersect_mesh(shape, &LocalRay { origin: r.origin, dir: r.dir, scale: 1.0 }, &mut sink);
    sink
}

fn together(shape: &MeshShape, rays: &[Ray], far: f64, any: bool) -> Vec<Option<(f64, Part)>> {
    let (mut packet, mut hits) = (Packet::default(), PacketHits::default());
    packet.set(rays.len(), |k| rays[k]);
    hits.set(rays.len(), |_| far);
    if any {
        intersect_mesh_packet::<true>(shape, &packet, &mut hits)
    } else {
        intersect_mesh_packet::<false>(shape, &packet, &mut hits)
    }
    (0..rays.len()).map(|k| hits.hit(k).map(|t| (t, hits.part(k)))).collect()
}

fn agree_on(triangles: &Triangles) {
    let mesh = Mesh { vertices: triangles.vertices.clone(), faces: triangles.faces.clone(), ..Mesh::default() };
    let shape = MeshShape::new(Arc::new(mesh), Vec::new(), AccelKind::Bvh8).expect("faces");
    let (mut source, mut numbers) = (RaySource::new(triangles, 11), SplitMix64(4));
    let (mut n_hits, mut n_rays, mut n_apart) = (0, 0, 0);
    for k in 0..N_PACKETS {
        let rays = packet(&mut source, &mut numbers, k);
        for any in [false, true] {
            let far = if numbers.below(3) == 0 { numbers.unit() * 2.0 } else { f64::INFINITY };
            let alone: Vec<Kept> = rays.iter().map(|r| alone(&shape, r, far, any)).collect();
            let together = together(&shape, &rays, far, any);
            n_rays += rays.len();
            n_hits += alone.iter().filter(|s| s.hit.is_some()).count();
            // Any hit will do: which is up to the order.
            let same = |a: &Kept, b: &Option<(f64, Part)>| if any { a.hit.is_some() == b.is_some() } else { a.hit == *b };
            n_apart += alone.iter().zip(&together).filter(|(a, b)| !same(a, b)).count();
        }
    }
    assert!(n_hits > n_rays / 50, "rays that hit nothing prove nothing: {n_hits} of {n_rays}");
    assert_eq!(n_apart, 0, "of {n_rays} rays, {n_hits} with hits");
}

#[test]
fn packets_hit_what_single_rays_do_on_a_soup_and_needles() {
    agree_on(&soup(2_500, 0.2, 1));
    agree_on(&needles(200));
}

#[test]
fn packets_hit_what_single_rays_do_on_closed_balls_near_and_far() {
    agree_on(&ball(4, true, 1.0));
    agree_on(&ball(3, true, 2.0).mapped(|p| p + FAR_AWAY));
}

#[test]
fn packets_hit_what_single_rays_do_on_flat_and_nested_things() {
    agree_on(&flat(11));
    agree_on(&nested_boxes(16));
    agree_on(&teapot_in_stadium());
    agree_on(&terrain(60));
}

#[test]
fn rays_that_are_none_meet_nothing_and_leave_the_others_alone() {
    let triangles = ball(2, true, 1.0);
    let mesh = Mesh { vertices: triangles.vertices.clone(), faces: triangles.faces.clone(), ..Mesh::default() };
    let shape = MeshShape::new(Arc::new(mesh), Vec::new(), AccelKind::Bvh8).expect("faces");
    let mut rays = vec![Ray::new(DVec3::ZERO, DVec3::X); 12];
    rays[3].dir = DVec3::ZERO;
    rays[5].dir = DVec3::NAN;
    rays[6].origin = DVec3::INFINITY;
    let hits: Vec<bool> = together(&shape, &rays, f64::INFINITY, false).iter().map(Option::is_some).collect();
    assert!((0..12).all(|k| hits[k] != [3, 5, 6].contains(&k)), "{hits:?}");
    assert_eq!(together(&shape, &[], f64::INFINITY, true), []);
}
