//! Density files. Source: spec/textures.md, section 2 (measured).

use crate::math::DVec3;
use crate::scene::DensityGrid;

/// The grid's value; 0 outside the unit cube. `interpolate` 0 nearest, 1 linear, else cubic.
pub fn density(grid: &DensityGrid, interpolate: u8, p: DVec3) -> f64 {
    let [nx, ny, nz] = grid.size.map(|n| n as usize);
    if !(p.cmpge(DVec3::ZERO).all() && p.cmplt(DVec3::ONE).all()) || nx * ny * nz == 0 {
        return 0.0;
    }
    let at = |x: usize, y: usize, z: usize| grid.values[(z * ny + y) * nx + x];
    let q = p * DVec3::new(nx as f64, ny as f64, nz as f64);
    let (ix, iy, iz) = (q.x as usize, q.y as usize, q.z as usize);
    match interpolate {
        0 => f64::from(at(ix.min(nx - 1), iy.min(ny - 1), iz.min(nz - 1))),
        1 => {
            let (fx, fy, fz) = (q.x.fract(), q.y.fract(), q.z.fract());
            let mut sum = 0.0;
            for (dz, wz) in [(0, 1.0 - fz), (1, fz)] {
                for (dy, wy) in [(0, 1.0 - fy), (1, fy)] {
                    for (dx, wx) in [(0, 1.0 - fx), (1, fx)] {
                        sum += wx * wy * wz * f64::from(at((ix + dx) % nx, (iy + dy) % ny, (iz + dz) % nz));
                    }
                }
            }
            sum
        }
        _ => {
            let (fx, fy, fz) = (q.x.fract() as f32, q.y.fract() as f32, q.z.fract() as f32);
            let (cx, cy, cz) = (around(ix, nx), around(iy, ny), around(iz, nz));
            let rows = cx.map(|x| catmull_rom(cy.map(|y| catmull_rom(cz.map(|z| at(x, y, z)), fz)), fy));
            f64::from(catmull_rom(rows, fx).max(0.0))
        }
    }
}

/// The four cells of a cubic. The one before cell 0 is `(2^64 - 1) mod n` (measured).
fn around(i: usize, n: usize) -> [usize; 4] {
    let before = if i == 0 { (u64::MAX % n as u64) as usize } else { (i - 1) % n };
    [before, i % n, (i + 1) % n, (i + 2) % n]
}

fn catmull_rom(v: [f32; 4], t: f32) -> f32 {
    let (b, e) = ((v[2] - v[0]) / 2.0, (v[3] - v[1]) / 2.0);
    let (a, d) = (v[1], v[2] - v[1]);
    let (t2, t3) = (t * t, t * t * t);
    a + b * t + (3.0 * d - 2.0 * b - e) * t2 + (b + e - 2.0 * d) * t3
}
