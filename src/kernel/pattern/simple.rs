//! Patterns of plain geometry. Source: spec/textures.md, section 2 (measured).

use super::{below_one, fraction};
use crate::compile::texture::SlopeParams;
use crate::kernel::PatternPoint;
use crate::math::{DVec3, EPSILON};
use std::f64::consts::{PI, TAU};

const SQRT3: f64 = 1.732_050_807_568_877_2;

/// 0 mortar, 1 brick.
pub fn brick(p: DVec3, size: DVec3, mortar: f64) -> f64 {
    let m = mortar - 2.0 * EPSILON;
    // The upper end of a joint belongs to the brick, the lower one to the joint, whatever roundings do (measured).
    let q = (p + DVec3::splat(mortar + EPSILON)) / size;
    let w = DVec3::splat(m) / size;
    let frac = |v: f64| v - v.floor();
    if frac(q.y) <= w.y {
        return 0.0;
    }
    let (along_x, along_z) = if frac(q.y * 0.5) <= 0.5 { (q.x, q.z + 0.5) } else { (q.x + 0.5, q.z) };
    f64::from(u8::from(frac(along_x) > w.x && frac(along_z) > w.z))
}

/// 1 in odd cells.
pub fn checker(p: DVec3) -> f64 {
    let f = (p + DVec3::splat(EPSILON)).floor();
    f64::from((f.x as i64).wrapping_add(f.y as i64).wrapping_add(f.z as i64) & 1 == 1)
}

/// The face that the point looks through: 0 +x, 1 +y, 2 +z, 3 -x, 4 -y, 5 -z.
pub fn cubic(p: DVec3) -> f64 {
    let a = p.abs();
    if p.x >= 0.0 && p.x >= a.y && p.x >= a.z {
        0.0
    } else if p.y >= 0.0 && p.y >= a.x && p.y >= a.z {
        1.0
    } else if p.z >= 0.0 && p.z >= a.x && p.z >= a.y {
        2.0
    } else if p.x < 0.0 && a.x >= a.y && a.x >= a.z {
        3.0
    } else if p.y < 0.0 && a.y >= a.x && a.y >= a.z {
        4.0
    } else {
        5.0
    }
}

/// Three hexagon colours in the x, z plane.
pub fn hexagon(p: DVec3) -> f64 {
    const HEIGHT: f64 = 0.866_025_404;
    const PERIOD: f64 = 5.196_152_424;
    let x = p.x.abs();
    let z = if p.z < 0.0 { PERIOD - p.z.abs() } else { p.z };
    // Far below zero the mirrored row index wraps the same way.
    let (u, v) = (x / 0.5, (if z < 0.0 { PERIOD - z.abs() % PERIOD } else { z }) / HEIGHT);
    let (column, row) = ((u.floor() % 6.0) as usize, (v.floor() % 6.0) as usize);
    let (mut a, b) = (u - u.floor(), v - v.floor());
    let pick: [u8; 6] = match column {
        0 | 5 => [0, 1, 1, 2, 2, 0],
        2 | 3 => [2, 2, 0, 0, 1, 1],
        _ => {
            if (column + row) % 2 == 1 {
                a = 1.0 - a;
            }
            if a == 0.0 {
                a = 0.0001;
            }
            if b / a < 1.0 { [0, 2, 1, 0, 2, 1] } else { [2, 1, 0, 2, 1, 0] }
        }
    };
    f64::from(pick[row.min(5)])
}

/// Four square colours in the x, z plane.
pub fn square(p: DVec3) -> f64 {
    let odd = |v: f64| v.floor() as i64 & 1 == 1;
    match (odd(p.x), odd(p.z)) {
        (false, false) => 0.0,
        (false, true) => 1.0,
        (true, true) => 2.0,
        (true, false) => 3.0,
    }
}

/// Six triangle colours in the x, z plane.
pub fn triangular(p: DVec3) -> f64 {
    let wrap = |v: f64, period: f64| v - (v / period).floor() * period;
    let (x, mut z) = (wrap(p.x, 3.0), wrap(p.z, SQRT3));
    let a = x.floor();
    let u = x - a;
    let upper = z >= SQRT3 / 2.0;
    if upper {
        z = SQRT3 - z;
    }
    let answer: i32 = if u == 0.0 {
        1
    } else {
        match (z / u < SQRT3, z / (1.0 - u) < SQRT3) {
            (true, true) => 0,
            (false, true) => 1,
            _ => 3,
        }
    };
    let a = a as i32;
    let turned = if answer % 2 == 1 { answer + 2 * a } else { answer - 2 * a }.rem_euclid(6);
    f64::from(if upper { 5 - turned } else { turned })
}

/// 0.25..1.25 around the y axis.
pub fn radial(p: DVec3) -> f64 {
    if p.x.abs() < 0.001 && p.z.abs() < 0.001 { 0.25 } else { 0.25 + (p.x.atan2(p.z) + PI) / TAU }
}

/// The place in a quilted cell and the stuffing's factor.
pub fn quilt(p: DVec3, control0: f64, control1: f64) -> (DVec3, f64) {
    // Equals floor but at negative integers, where it is one lower.
    let floor = |v: f64| if v >= 0.0 { v.floor() } else { -(-v).floor() - 1.0 };
    let q = DVec3::new(p.x - floor(p.x) - 0.5, p.y - floor(p.y) - 0.5, p.z - floor(p.z) - 0.5);
    let t = q.length();
    let s = t * t * t + 3.0 * t * (1.0 - t) * (1.0 - t) * control0 + 3.0 * t * t * (1.0 - t) * control1;
    (q, s * 1.154_700_538)
}

/// How steep the surface is, with its height if asked.
pub fn slope(s: &SlopeParams, p: DVec3, at: &PatternPoint) -> f64 {
    if at.normal == DVec3::ZERO {
        return 0.0;
    }
    let direction = if s.point_at { (s.direction - at.world).normalize_or_zero() } else { s.direction };
    let ranged = |v: f64, low: f64, high: f64| if high != 0.0 && high != low { (v - low) / (high - low) } else { v };
    let angle = at.normal.dot(direction).clamp(-1.0, 1.0).asin();
    let v = ranged((angle * 2.0 / PI + 1.0) * 0.5, s.low, s.high);
    match s.altitude {
        None if v == 1.0 => 1.0 - EPSILON,
        None if v < 0.0 => 1.0 + fraction(v),
        None => fraction(v),
        Some((axis, low, high, share)) => below_one(share * v + (1.0 - share) * ranged(p.dot(axis), low, high)),
    }
}
