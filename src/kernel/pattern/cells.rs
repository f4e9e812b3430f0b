//! Patterns of random points, one a unit cell: cells, crackle, facets. Source: spec/textures.md, sections 2 and 3 (measured).

use crate::math::noise::noise;
use crate::math::random::{UNIFORM_TABLE_LEN, hash3, uniform_table};
use crate::math::{DVec3, EPSILON};

/// A random number a cell.
pub fn cells(p: DVec3) -> f64 {
    let c = (p + DVec3::splat(EPSILON)).floor();
    uniform_table()[hash3(c.x as i64, c.y as i64, c.z as i64)]
}

/// The random point of a cell.
#[inline]
fn cell_point(table: &[f64], x: i64, y: i64, z: i64) -> DVec3 {
    let h = hash3(x, y, z);
    // The hash is below 4096, the table far longer.
    let r = &table[h..h + 3];
    DVec3::new(x as f64 + r[0], y as f64 + r[1], z as f64 + r[2])
}

/// Calls `f` with the points of the 81 cells around `base`: those at most two away, and two away along one axis at most.
#[inline]
fn around(base: [i64; 3], mut f: impl FnMut(DVec3)) {
    let table = &uniform_table()[..UNIFORM_TABLE_LEN];
    for dx in -2i64..=2 {
        for dy in -2i64..=2 {
            for dz in -2i64..=2 {
                let far = (dx.abs() == 2) as u8 + (dy.abs() == 2) as u8 + (dz.abs() == 2) as u8;
                if far <= 1 {
                    f(cell_point(table, base[0] + dx, base[1] + dy, base[2] + dz));
                }
            }
        }
    }
}

fn base_cell(p: DVec3) -> [i64; 3] {
    let b = (p - DVec3::splat(EPSILON)).floor();
    [b.x as i64, b.y as i64, b.z as i64]
}

/// Distances to the nearest three points, combined.
pub fn crackle(p: DVec3, form: DVec3, metric: f64, offset: f64, solid: bool, generator: u8) -> f64 {
    let base = base_cell(p);
    let mut nearest = DVec3::ZERO;
    let mut d = [f64::INFINITY; 3];
    let square = metric == 2.0;
    around(base, |q| {
        let e = q - p;
        let sum = if square {
            e.length_squared()
        } else if metric == 1.0 {
            e.x.abs() + e.y.abs() + e.z.abs()
        } else {
            e.x.abs().powf(metric) + e.y.abs().powf(metric) + e.z.abs().powf(metric)
        };
        if sum < d[0] {
            nearest = q;
            d = [sum, d[0], d[1]];
        } else if sum < d[1] {
            d = [d[0], sum, d[1]];
        } else if sum < d[2] {
            d[2] = sum;
        }
    });
    if solid {
        return noise(nearest, generator);
    }
    let root = |mut s: f64| {
        if offset != 0.0 {
            s += if square {
                offset * offset
            } else if metric == 1.0 {
                offset
            } else {
                offset.powf(metric)
            };
        }
        if square {
            s.sqrt()
        } else if metric == 1.0 {
            s
        } else {
            s.powf(1.0 / metric)
        }
    };
    let mut v = 0.0;
    for k in 0..3 {
        if form[k] != 0.0 {
            v += form[k] * root(d[k]);
        }
    }
    v.clamp(0.0, 1.0)
}

/// The random point nearest to `p` by a facets metric: 1 is the signed sum (a quirk), 2 the plain distance, others powers.
pub fn nearest_facet(p: DVec3, metric: f64) -> DVec3 {
    // Neighbours are the cells of moved points, so the base must not be floored first.
    let base = base_cell(p);
    let (mut nearest, mut least) = (DVec3::ZERO, f64::INFINITY);
    around(base, |q| {
        let e = q - p;
        let d = if metric == 2.0 {
            e.length_squared()
        } else if metric == 1.0 {
            e.x + e.y + e.z
        } else {
            e.x.abs().powf(metric) + e.y.abs().powf(metric) + e.z.abs().powf(metric)
        };
        if d < least {
            (nearest, least) = (q, d);
        }
    });
    nearest
}
