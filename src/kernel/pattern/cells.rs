//! Patterns of random points, one a unit cell: cells, crackle, facets. Source: spec/textures.md, sections 2 and 3 (measured).

use crate::math::noise::noise;
use crate::math::random::{HASH, HASH_LEN, UNIFORM_TABLE_LEN, hash3, uniform_table};
use crate::math::simd::kernels::{NearestOf, least_squares};
use crate::math::{DVec3, EPSILON};
use std::cell::RefCell;

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

#[inline]
fn base_cell(p: DVec3) -> [i64; 3] {
    (p - DVec3::splat(EPSILON)).to_array().map(|v| {
        // Not f64::floor, a call into the library without SSE4.1.
        let i = v as i64;
        if (i as f64) > v { i.saturating_sub(1) } else { i }
    })
}

/// The random points of the 27 cells at and next to one, by axis; the last place is far away.
struct NearPoints {
    base: [i64; 3],
    points: NearestOf,
}

impl NearPoints {
    fn fill(&mut self, base: [i64; 3]) {
        let table = &uniform_table()[..UNIFORM_TABLE_LEN];
        let h = |n: usize| usize::from(HASH[n & (HASH_LEN - 1)]);
        let wrapped = |axis: usize, o: i64| (base[axis].wrapping_add(o) & 4095) as usize;
        let mut k = 0;
        for x in -1..=1 {
            let hx = h(wrapped(0, x));
            for y in -1..=1 {
                let hy = h(hx ^ wrapped(1, y));
                for z in -1..=1 {
                    let hz = h(hy ^ wrapped(2, z));
                    let r = &table[hz..hz + 3];
                    for (axis, o) in [x, y, z].into_iter().enumerate() {
                        self.points[axis][k] = base[axis].wrapping_add(o) as f64 + r[axis];
                    }
                    k += 1;
                }
            }
        }
        self.base = base;
    }
}

/// Cells whose points are kept, each at a place of its own modulo this: all neighbours of a cell, so rays that cross cells find them.
const N_NEAR: usize = 32;

thread_local! {
    /// Kept between samples, which come in runs. Measured: textures/patterns/crackle3 and interior/media/micro, see docs/speed.md.
    static NEAR: RefCell<[NearPoints; N_NEAR]> =
        const { RefCell::new([const { NearPoints { base: [i64::MIN; 3], points: [[1e30; 28]; 3] } }; N_NEAR]) };
}

/// As [`nearest`] with squares, from the 27 points at hand; where one of those farther away could be nearer, `nearest` itself.
fn nearest_by_squares<const N: usize>(p: DVec3) -> ([f64; N], DVec3) {
    let base = base_cell(p);
    NEAR.with_borrow_mut(|kept| {
        let place = base[0].wrapping_add(base[1].wrapping_mul(3)).wrapping_add(base[2].wrapping_mul(9));
        let near = &mut kept[place as usize % N_NEAR];
        if near.base != base {
            near.fill(base);
        }
        let d: [f64; N] = least_squares(&near.points, p);
        // All points of cells two away are at least one away.
        if !(d[N - 1] < 0.999) {
            return nearest(p, |v| v * v);
        }
        let [x, y, z] = &near.points;
        let points = (0..27).map(|k| DVec3::new(x[k], y[k], z[k]));
        let q = if N > 1 { DVec3::ZERO } else { points.into_iter().find(|q| square_distance(*q, p) == d[0]).unwrap_or_default() };
        (d, q)
    })
}

#[inline]
fn square_distance(q: DVec3, p: DVec3) -> f64 {
    let e = q - p;
    e.x * e.x + e.y * e.y + e.z * e.z
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

/// As many distances as the form needs, the others are 0; and, where one is needed, the nearest point.
#[inline(always)]
fn distances(
    needed: usize,
    one: impl Fn() -> ([f64; 1], DVec3),
    two: impl Fn() -> ([f64; 2], DVec3),
    three: impl Fn() -> ([f64; 3], DVec3),
) -> ([f64; 3], DVec3) {
    match needed {
        0 | 1 => {
            let ([a], q) = one();
            ([a, 0.0, 0.0], q)
        }
        2 => {
            let ([a, b], q) = two();
            ([a, b, 0.0], q)
        }
        _ => three(),
    }
}

/// As many sums of powers as the form needs, by another metric than squares.
#[inline(never)]
fn by_metric(needed: usize, p: DVec3, metric: f64) -> ([f64; 3], DVec3) {
    let halves = 2.0 * metric;
    if metric == 1.0 {
        distances(needed, || nearest(p, |v| v), || nearest(p, |v| v), || nearest(p, |v| v))
    } else if halves.fract() == 0.0 && (1.0..=16.0).contains(&halves) {
        // Halves of whole numbers: products and a root are far quicker than the library's power.
        let root_counts = metric.fract() != 0.0;
        let power = |v: f64| (0..metric as u32).fold(if root_counts { v.sqrt() } else { 1.0 }, |p, _| p * v);
        distances(needed, || nearest(p, power), || nearest(p, power), || nearest(p, power))
    } else {
        let power = |v: f64| v.powf(metric);
        distances(needed, || nearest(p, power), || nearest(p, power), || nearest(p, power))
    }
}

/// Distances to the nearest three points, combined.
pub fn crackle(p: DVec3, form: DVec3, metric: f64, offset: f64, solid: bool, generator: u8) -> f64 {
    let square = metric == 2.0;
    let needed = if solid { 1 } else { (0..3).rev().find(|k| form[*k] != 0.0).map_or(1, |k| k + 1) };
    let (d, nearest) = if square {
        distances(needed, || nearest_by_squares(p), || nearest_by_squares(p), || nearest_by_squares(p))
    } else {
        by_metric(needed, p, metric)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_halves_are_the_library_s() {
        for metric in [0.5, 1.5, 2.5, 3.0, 7.5, 8.0] {
            for i in 0..300 {
                let i = f64::from(i);
                let p = DVec3::new((i * 0.37).sin() * 9.0, i * 0.11 - 7.0, (i * 0.73).cos() * 5.0);
                let (d, q) = by_metric(3, p, metric);
                let power = |v: f64| v.powf(metric);
                let (want, at): ([f64; 3], DVec3) = nearest(p, power);
                assert!(q == at && d.iter().zip(want).all(|(d, want)| (d - want).abs() < 1e-13 * want), "{metric} {p}: {d:?}, {want:?}");
            }
        }
    }

    #[test]
    fn points_at_hand_give_what_the_search_through_all_cells_gives() {
        for i in 0..20_000 {
            let i = f64::from(i);
            let p = DVec3::new((i * 0.37).sin() * 9.0, i * 0.013 - 100.0, (i * 0.11).cos() * 4100.0);
            assert_eq!(nearest_by_squares::<1>(p), nearest(p, |v| v * v), "{p}");
            assert_eq!(nearest_by_squares::<2>(p).0, nearest::<2>(p, |v| v * v).0, "{p}");
            assert_eq!(nearest_by_squares::<3>(p).0, nearest::<3>(p, |v| v * v).0, "{p}");
        }
    }
}
