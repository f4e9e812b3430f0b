//! Patterns of random points, one a unit cell: cells, crackle, facets. Source: spec/textures.md, sections 2 and 3 (measured).

use crate::math::noise::noise;
use crate::math::random::{HASH, HASH_LEN, UNIFORM_TABLE_LEN, hash3, uniform_table};
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

/// The `N` smallest distance sums to the points around `p`, and the nearest point. `power` is the metric's term of one axis.
///
/// Of the same 81 cells as [`around`] those are skipped whose nearest corner is already too far.
#[inline(always)]
fn nearest<const N: usize>(p: DVec3, power: impl Fn(f64) -> f64) -> ([f64; N], DVec3) {
    const ORDER: [i64; 5] = [0, -1, 1, -2, 2];
    let table = &uniform_table()[..UNIFORM_TABLE_LEN];
    let base = base_cell(p);
    // The least term of each axis for cells in `ORDER`.
    let least: [[f64; 5]; 3] = std::array::from_fn(|axis| {
        ORDER.map(|o| {
            let gap = match o {
                0 => 0.0,
                1.. => (base[axis] + o) as f64 - p[axis],
                _ => p[axis] - (base[axis] + o + 1) as f64,
            };
            power(gap.max(0.0))
        })
    });
    let h = |n: usize| usize::from(HASH[n & (HASH_LEN - 1)]);
    let (mut d, mut nearest) = ([f64::INFINITY; N], DVec3::ZERO);
    for (i, ox) in ORDER.iter().enumerate() {
        if least[0][i] >= d[N - 1] {
            continue;
        }
        let hx = h(((base[0] + ox) & 4095) as usize);
        for (j, oy) in ORDER[..if i > 2 { 3 } else { 5 }].iter().enumerate() {
            let near_xy = least[0][i] + least[1][j];
            if near_xy >= d[N - 1] {
                continue;
            }
            let hy = h(hx ^ ((base[1] + oy) & 4095) as usize);
            for (k, oz) in ORDER[..if i > 2 || j > 2 { 3 } else { 5 }].iter().enumerate() {
                if near_xy + least[2][k] >= d[N - 1] {
                    continue;
                }
                let hz = h(hy ^ ((base[2] + oz) & 4095) as usize);
                let r = &table[hz..hz + 3];
                let q = DVec3::new((base[0] + ox) as f64 + r[0], (base[1] + oy) as f64 + r[1], (base[2] + oz) as f64 + r[2]);
                let e = q - p;
                let mut sum = power(e.x.abs()) + power(e.y.abs()) + power(e.z.abs());
                if sum < d[0] {
                    nearest = q;
                }
                // Keeps the list sorted.
                for kept in &mut d {
                    if sum < *kept {
                        std::mem::swap(&mut sum, kept);
                    }
                }
            }
        }
    }
    (d, nearest)
}

/// As many distances as the form needs; the others are 0.
#[inline(always)]
fn distances(p: DVec3, needed: usize, power: impl Fn(f64) -> f64 + Copy) -> ([f64; 3], DVec3) {
    match needed {
        0 | 1 => {
            let ([a], q) = nearest::<1>(p, power);
            ([a, 0.0, 0.0], q)
        }
        2 => {
            let ([a, b], q) = nearest::<2>(p, power);
            ([a, b, 0.0], q)
        }
        _ => nearest::<3>(p, power),
    }
}

/// Distances to the nearest three points, combined.
pub fn crackle(p: DVec3, form: DVec3, metric: f64, offset: f64, solid: bool, generator: u8) -> f64 {
    let square = metric == 2.0;
    let needed = if solid { 1 } else { (0..3).rev().find(|k| form[*k] != 0.0).map_or(1, |k| k + 1) };
    let (d, nearest) = if square {
        distances(p, needed, |v| v * v)
    } else if metric == 1.0 {
        distances(p, needed, |v| v)
    } else {
        distances(p, needed, |v| v.powf(metric))
    };
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
