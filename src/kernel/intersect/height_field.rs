//! Height fields: a walk over the cells under the ray, blocks of cells first. Source: spec/objects.md, section 7.

use super::{HitSink, LocalRay, Part};
use crate::compile::shape::height::{BLOCK, HeightFieldShape};
use crate::math::{DVec3, MAX_DISTANCE, Transform};

/// Hits nearer than this (in grid units) are not seen.
const TOLERANCE: f64 = 1e-6;
/// Triangles reach this far beyond their edges, in cells.
const SLACK: f64 = 1e-4;

/// Crossings in the order of the cells; without `all`, those of the first cell that has any.
pub fn intersect_height_field(s: &HeightFieldShape, ray: &LocalRay, all: bool, sink: &mut impl HitSink) {
    let b = s.bounds();
    let (mut t0, mut t1) = (0.0f64, MAX_DISTANCE);
    for k in 0..3 {
        let (o, d) = (ray.origin[k], ray.dir[k]);
        if d == 0.0 {
            if o < b.min[k] || o > b.max[k] {
                return;
            }
            continue;
        }
        let (a, c) = ((b.min[k] - o) / d, (b.max[k] - o) / d);
        t0 = t0.max(a.min(c));
        t1 = t1.min(a.max(c));
    }
    if t0 > t1 {
        return;
    }
    let (cells_x, cells_z) = (s.grid.width - 1, s.grid.height - 1);
    let mut found = false;
    // Blocks under the ray, then the cells of each block that the ray's heights may meet.
    walk(ray, f64::from(BLOCK), cells_x.div_ceil(BLOCK), cells_z.div_ceil(BLOCK), t0, t1, |bx, bz, u0, u1| {
        let (low, high) = s.blocks[(bz * s.blocks_x + bx) as usize];
        if !meets(ray, u0, u1, low.into(), high.into()) {
            return true;
        }
        walk(ray, 1.0, cells_x, cells_z, u0, u1, |x, z, v0, v1| {
            let h = [s.height(x, z), s.height(x + 1, z), s.height(x, z + 1), s.height(x + 1, z + 1)];
            let (low, high) = (h[0].min(h[1]).min(h[2]).min(h[3]), h[0].max(h[1]).max(h[2]).max(h[3]));
            if meets(ray, v0, v1, low, high) && cell(s, ray, x, z, h, sink) {
                found = true;
            }
            !found || all
        });
        (!found || all) && u0 <= sink.far()
    });
}

/// Whether the ray's heights between two depths meet an interval, with some slack.
#[inline]
fn meets(ray: &LocalRay, t0: f64, t1: f64, low: f64, high: f64) -> bool {
    let (a, b) = (ray.origin.y + t0 * ray.dir.y, ray.origin.y + t1 * ray.dir.y);
    // The slack of the triangles reaches a little into the neighbours.
    let slack = 1e-3 + 2.0 * SLACK * (high - low) + 1e-6 * (b - a).abs();
    a.max(b) >= low - slack && a.min(b) <= high + slack
}

/// Visits the squares of side `size` under the ray from `t0` to `t1` with the depths of entry and exit, until `visit` is false.
fn walk(ray: &LocalRay, size: f64, nx: u32, nz: u32, t0: f64, t1: f64, mut visit: impl FnMut(u32, u32, f64, f64) -> bool) {
    let (o, d) = (ray.origin, ray.dir);
    let start = ray.at(t0);
    let cell_of = |v: f64, n: u32| ((v / size).floor().max(0.0) as u32).min(n - 1);
    let (mut x, mut z) = (cell_of(start.x, nx), cell_of(start.z, nz));
    let next = |c: u32, o: f64, d: f64| {
        if d == 0.0 { f64::INFINITY } else { (f64::from(c + u32::from(d > 0.0)) * size - o) / d }
    };
    let (step_x, step_z) = ((size / d.x).abs(), (size / d.z).abs());
    let (mut next_x, mut next_z) = (next(x, o.x, d.x), next(z, o.z, d.z));
    let mut t = t0;
    loop {
        let exit = next_x.min(next_z).min(t1);
        if !visit(x, z, t, exit) || exit >= t1 {
            return;
        }
        t = exit.max(t);
        let (c, n, d, at, step) =
            if next_x < next_z { (&mut x, nx, d.x, &mut next_x, step_x) } else { (&mut z, nz, d.z, &mut next_z, step_z) };
        if d > 0.0 {
            *c += 1;
            if *c >= n {
                return;
            }
        } else {
            if *c == 0 {
                return;
            }
            *c -= 1;
        }
        *at += step;
    }
}

/// Both triangles of a cell; whether one was hit.
fn cell(s: &HeightFieldShape, ray: &LocalRay, x: u32, z: u32, h: [f64; 4], sink: &mut impl HitSink) -> bool {
    let (fx, fz) = (f64::from(x), f64::from(z));
    let mut found = false;
    for upper in [false, true] {
        let (y, sx, sz) = plane(h, upper);
        // y = y0 + sx (px - fx) + sz (pz - fz)
        let slope = ray.dir.y - sx * ray.dir.x - sz * ray.dir.z;
        if slope == 0.0 {
            continue;
        }
        let t = (y + sx * (ray.origin.x - fx) + sz * (ray.origin.z - fz) - ray.origin.y) / slope;
        if !(t > TOLERANCE && t < MAX_DISTANCE) {
            continue;
        }
        let p = ray.at(t);
        let (u, v) = (p.x - fx, p.z - fz);
        let (u, v) = if upper { (1.0 - u, 1.0 - v) } else { (u, v) };
        if u >= -SLACK && v >= -SLACK && u + v <= 1.0 + SLACK && p.y >= s.low && p.y <= s.high {
            sink.push(t, Part { face: 2 * (z * (s.grid.width - 1) + x) + u32::from(upper), a: p.x - fx, b: p.z - fz });
            found = true;
        }
    }
    found
}

/// Height at the cell's corner and slopes along x and z of the lower or upper triangle's plane.
#[inline]
fn plane(h: [f64; 4], upper: bool) -> (f64, f64, f64) {
    if upper {
        let (sx, sz) = (h[3] - h[2], h[3] - h[1]);
        (h[3] - sx - sz, sx, sz)
    } else {
        (h[0], h[1] - h[0], h[2] - h[0])
    }
}

/// Below the surface, without limit downwards.
pub fn inside_height_field(s: &HeightFieldShape, p: DVec3) -> bool {
    let (w, d) = (f64::from(s.grid.width - 1), f64::from(s.grid.height - 1));
    if p.x < 0.0 || p.z < 0.0 || p.x >= w || p.z >= d {
        return false;
    }
    if p.y < s.water {
        return true;
    }
    let (x, z) = (p.x as u32, p.z as u32);
    let h = [s.height(x, z), s.height(x + 1, z), s.height(x, z + 1), s.height(x + 1, z + 1)];
    let (u, v) = (p.x - f64::from(x), p.z - f64::from(z));
    let (y, sx, sz) = plane(h, u + v >= 1.0);
    p.y < y + sx * u + sz * v
}

/// World normal, not unit; `t` is the primitive's transform.
pub fn height_field_normal(s: &HeightFieldShape, t: &Transform, part: &Part) -> DVec3 {
    let cell = part.face / 2;
    let (x, z) = (cell % (s.grid.width - 1), cell / (s.grid.width - 1));
    if s.smooth {
        let n = |dx, dz| t.normal(vertex_normal(s, x + dx, z + dz)).normalize_or_zero();
        let (u, v) = (part.a, part.b);
        return (1.0 - v) * ((1.0 - u) * n(0, 0) + u * n(1, 0)) + v * ((1.0 - u) * n(0, 1) + u * n(1, 1));
    }
    let h = [s.height(x, z), s.height(x + 1, z), s.height(x, z + 1), s.height(x + 1, z + 1)];
    let (_, sx, sz) = plane(h, part.face & 1 == 1);
    t.normal(DVec3::new(-sx, 1.0, -sz))
}

/// Mean of the normals of up to four triangles with consecutive axis neighbours, kept in 16 bits as POV-Ray does.
fn vertex_normal(s: &HeightFieldShape, x: u32, z: u32) -> DVec3 {
    let y = s.height(x, z);
    let east = (x + 1 < s.grid.width).then(|| s.height(x + 1, z) - y);
    let west = (x > 0).then(|| y - s.height(x - 1, z));
    let north = (z + 1 < s.grid.height).then(|| s.height(x, z + 1) - y);
    let south = (z > 0).then(|| y - s.height(x, z - 1));
    let mut n = DVec3::ZERO;
    for (sx, sz) in [(east, north), (east, south), (west, south), (west, north)] {
        if let (Some(sx), Some(sz)) = (sx, sz) {
            n += DVec3::new(-sx, 1.0, -sz).normalize();
        }
    }
    (n.normalize_or_zero() * 32767.0).trunc() / 32767.0
}
