//! Bends of the point before a pattern sees it. Source: spec/textures.md, section 4 (all measured).

use crate::compile::CompiledScene;
use crate::compile::texture::{PatternNode, WarpNode};
use crate::math::noise::turbulence_vector;
use crate::math::random::{UNIFORM_TABLE_LEN, hash3, uniform_table};
use crate::math::{DVec3, EPSILON};
use std::f64::consts::{PI, TAU};

/// Coordinates are kept within this after all warps.
const MOST: f64 = 1e17;

/// The point that pattern `pattern_ix` sees when it is asked about `p`, classic turbulence included.
#[inline]
pub fn warp_point(scene: &CompiledScene, pattern_ix: u32, p: DVec3) -> DVec3 {
    warp_by(scene, &scene.textures.patterns[pattern_ix as usize], p)
}

/// The same for a pattern at hand.
#[inline]
pub fn warp_by(scene: &CompiledScene, pattern: &PatternNode, p: DVec3) -> DVec3 {
    let warped = pattern.warps.of(&scene.textures.warps).iter().fold(p, |p, w| warp(w, p));
    // NaN stays NaN.
    if warped.abs().max_element() > MOST { DVec3::from_array(warped.to_array().map(|v| v.clamp(-MOST, MOST))) } else { warped }
}

fn warp(w: &WarpNode, p: DVec3) -> DVec3 {
    match *w {
        WarpNode::Affine(inverse) => inverse.transform_point3(p),
        WarpNode::Turbulence { amount, noise } => p + amount * turbulence_vector(p, noise.octaves, noise.omega, noise.lambda),
        WarpNode::Repeat { axis, width, offset, flip } => {
            let (axis, mut p) = (usize::from(axis), p);
            // The product is rounded to 32 bits (measured).
            let block = f64::from((p[axis] / width).floor() as f32);
            p[axis] -= f64::from((block * width) as f32);
            if block - 2.0 * (block / 2.0).trunc() != 0.0 {
                for k in 0..3 {
                    if flip[k] {
                        p[k] = if k == axis { width - p[k] } else { -p[k] };
                    }
                }
            }
            p + block * offset
        }
        WarpNode::BlackHole { center, radius, strength, inverse, falloff, repeat, repeats, turbulence } => {
            let mut c = center;
            if repeats {
                let mut block = DVec3::ZERO;
                for k in 0..3 {
                    if repeat[k] >= EPSILON {
                        block[k] = (p[k] / repeat[k]).floor();
                    }
                }
                if turbulence != DVec3::ZERO {
                    let h = hash3(block.x as i64, block.y as i64, block.z as i64);
                    let r = uniform_table();
                    let at = |k: usize| r[(h + k) % UNIFORM_TABLE_LEN];
                    c += turbulence * DVec3::new(at(0), at(1), at(2));
                }
                c += repeat * block;
            }
            let d = p - c;
            let len = d.length();
            if len >= radius {
                return p;
            }
            let pull = (((radius - len) / radius).powf(falloff) * strength).min(1.0);
            if inverse { p - pull * d } else { p + pull * d }
        }
        WarpNode::Cylindrical { orientation, dist_exp } => {
            let r = (p.x * p.x + p.z * p.z).sqrt();
            if r == 0.0 {
                return p;
            }
            turned(orientation, DVec3::new(turns(p.x, p.z, r) * scale(r, dist_exp), p.y, r))
        }
        WarpNode::Spherical { orientation, dist_exp } => {
            let (dist, r) = (p.length(), (p.x * p.x + p.z * p.z).sqrt());
            if dist == 0.0 {
                return p;
            }
            let k = scale(dist, dist_exp);
            turned(orientation, DVec3::new(turns(p.x, p.z, r) * k, (0.5 + (p.y / dist).clamp(-1.0, 1.0).asin() / PI) * k, dist))
        }
        WarpNode::Toroidal { orientation, dist_exp, major_radius } => {
            if p.x == 0.0 && p.z == 0.0 {
                return p;
            }
            let (theta, phi, len) = torus_coordinates(p, major_radius);
            let k = scale(len, dist_exp);
            turned(orientation, DVec3::new(theta * k, phi * k, len))
        }
        WarpNode::Planar { orientation, distance } => turned(orientation, DVec3::new(p.x, p.y, distance)),
        WarpNode::Cubic => cube_map(p),
    }
}

fn scale(dist: f64, exponent: f64) -> f64 {
    if exponent == 0.0 { 1.0 } else { dist.powf(exponent) }
}

/// 0..1 around the y axis from +x towards +z; `r` is the distance to the axis. 0 on it.
pub(super) fn turns(x: f64, z: f64, r: f64) -> f64 {
    if r == 0.0 {
        return 0.0;
    }
    let angle = (x / r).clamp(-1.0, 1.0).acos();
    (if z < 0.0 { TAU - angle } else { angle }) / TAU
}

/// Around the axis and around the tube, each 0..1, and the distance to the tube's centre line.
pub(super) fn torus_coordinates(p: DVec3, major: f64) -> (f64, f64, f64) {
    let axis = (p.x * p.x + p.z * p.z).sqrt();
    let r = axis - major;
    let len = (r * r + p.y * p.y).sqrt();
    // On the centre line this is NaN, as in POV-Ray.
    let mut phi = (-r / len).clamp(-1.0, 1.0).acos();
    if p.y > 0.0 {
        phi = TAU - phi;
    }
    (turns(p.x, p.z, axis), phi / TAU, len)
}

/// Maps the result of a warp about z to the axis `o`.
fn turned(o: DVec3, v: DVec3) -> DVec3 {
    if o == DVec3::Z {
        return v;
    }
    DVec3::new(o.x * v.z + (o.y + o.z) * v.x, (o.x + o.z) * v.y - o.y * v.z, -o.x * v.x + o.y * v.y + o.z * v.z)
}

fn cube_map(p: DVec3) -> DVec3 {
    let a = p.abs();
    let (u, v, w) = if a.x >= a.y && a.x >= a.z {
        let v = 1.0 / 3.0 + (p.y / a.x + 1.0) / 6.0;
        (if p.x > 0.0 { 0.75 - 0.125 * (p.z / a.x + 1.0) } else { 0.125 * (p.z / a.x + 1.0) }, v, a.x)
    } else if a.y >= a.z {
        let v = (p.z / a.y + 1.0) / 6.0;
        (0.25 + 0.125 * (p.x / a.y + 1.0), if p.y > 0.0 { 1.0 - v } else { v }, a.y)
    } else {
        let v = 1.0 / 3.0 + (p.y / a.z + 1.0) / 6.0;
        (if p.z > 0.0 { 0.25 + 0.125 * (p.x / a.z + 1.0) } else { 1.0 - 0.125 * (p.x / a.z + 1.0) }, v, a.z)
    };
    DVec3::new(u, v, w)
}
