//! Tilings of the x, z plane by polygons of side 1. Source: spec/textures.md, section 2; places, kinds and falloffs measured on
//! pictures of every tiling (500 x 500 pixels of 10 x 10 units).
//!
//! A tile's kind picks its part of 0..1; inside, the value is highest at the sides and falls to the part's start at the inner radius of
//! the smallest tile. Tilings 25 to 27 are Penrose's (`penrose.rs`).

use super::penrose::{penrose, penrose_plan};
use crate::compile::texture::N_TILINGS;
use crate::math::{DVec3, EPSILON};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI};
use std::sync::LazyLock;

/// Half the square root of 3: the height of a triangle.
const A: f64 = 0.866_025_403_784_438_6;
/// Inner radius of a triangle.
const T: f64 = 0.288_675_134_594_812_9;

/// x and z.
pub type Point = [f64; 2];
/// A kind and its polygon.
pub(super) type Tile = (u8, Vec<Point>);

/// A tiling: kinds, falloff distance, the lattice that repeats it, and its tiles.
struct Plan {
    kinds: u8,
    falloff: f64,
    lattice: [Point; 2],
    tiles: Vec<Tile>,
}

/// Sides of a tile as (x, z, offset): a point's distance inwards, in falloffs, is `x * px + z * pz + offset`.
pub type Sides = Vec<[f64; 3]>;

/// A tiling ready for lookups: all tiles that meet the lattice's first cell.
#[derive(Debug)]
pub struct Tiling {
    /// Number of kinds of tiles.
    pub kinds: f64,
    /// What repeats it, in x and z.
    pub lattice: [Point; 2],
    /// Tiles by their kind.
    pub tiles: Vec<(f64, Sides)>,
    /// Least depth value, far from the sides of large tiles.
    pub floor: f64,
}

/// What the program adds to the start of a part far from the sides, so that a map's step at the part's start lies below it (measured
/// to 1e-9; it shows where a colour map jumps at the start of a part).
fn floor_of(n: u8) -> f64 {
    match n {
        7 => 2e-12,
        8 | 9 | 16 | 22 => 1e-7,
        14 | 17 | 19 | 20 | 23 | 24 => 1e-6,
        15 => 2e-8,
        21 => 5e-7,
        _ => 0.0,
    }
}

static TILINGS: LazyLock<Vec<Tiling>> = LazyLock::new(|| (1..=N_TILINGS).map(|n| Tiling::new(n, plan(n))).collect());

/// A tiling by its number; `None` for those that no lattice repeats.
pub fn tiling_plan(n: u8) -> Option<&'static Tiling> {
    TILINGS.get(usize::from(n).wrapping_sub(1))
}

/// The value of tiling 1..=27, 0..=1.
pub fn tiling(p: DVec3, n: u8) -> f64 {
    let Some(t) = tiling_plan(n) else { return penrose_plan(n).map_or(0.0, |t| penrose([p.x, p.z], t)) };
    let [u, v] = t.lattice;
    let det = u[0] * v[1] - u[1] * v[0];
    let (a, b) = (((p.x * v[1] - p.z * v[0]) / det).floor(), ((u[0] * p.z - u[1] * p.x) / det).floor());
    let (x, z) = (p.x - a * u[0] - b * v[0], p.z - a * u[1] - b * v[1]);
    let depth_at = |sides: &Sides, x: f64, z: f64| sides.iter().map(|s| s[0] * x + s[1] * z + s[2]).fold(f64::INFINITY, f64::min);
    let value = |kind: f64, depth: f64| (kind + (1.0 - depth).clamp(t.floor, 1.0)) / t.kinds;
    // On a side the deeper tile has the point, whatever rounding left of it; on a tie the tile ahead.
    let (mut deepest, mut found) = (f64::NEG_INFINITY, 0.0);
    for (kind, sides) in &t.tiles {
        let depth = depth_at(sides, x, z);
        if depth > EPSILON {
            return value(*kind, depth);
        }
        if depth > deepest || depth == deepest && depth_at(sides, x + EPSILON, z + EPSILON) > 0.0 {
            (deepest, found) = (depth, value(*kind, depth));
        }
    }
    found
}

impl Tiling {
    fn new(n: u8, plan: Plan) -> Self {
        let [u, v] = plan.lattice;
        let det = u[0] * v[1] - u[1] * v[0];
        let mut tiles = Vec::new();
        for (kind, polygon) in &plan.tiles {
            for i in -4..=4 {
                for j in -4..=4 {
                    let (i, j) = (f64::from(i), f64::from(j));
                    let moved: Vec<Point> = polygon.iter().map(|q| [q[0] + i * u[0] + j * v[0], q[1] + i * u[1] + j * v[1]]).collect();
                    // The box of the tile in lattice coordinates; a tile beside the cell does no harm.
                    let a = moved.iter().map(|q| (q[0] * v[1] - q[1] * v[0]) / det);
                    let b = moved.iter().map(|q| (u[0] * q[1] - u[1] * q[0]) / det);
                    let meets = |c: &mut dyn Iterator<Item = f64>| {
                        let (lo, hi) = c.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), c| (lo.min(c), hi.max(c)));
                        lo < 1.0 + 1e-9 && hi > -1e-9
                    };
                    if meets(&mut a.into_iter()) && meets(&mut b.into_iter()) {
                        tiles.push((f64::from(*kind), sides(&moved, plan.falloff, n == 22)));
                    }
                }
            }
        }
        Self { kinds: f64::from(plan.kinds), lattice: plan.lattice, tiles, floor: floor_of(n) }
    }
}

/// `flat`: the upright sides and the lowest of tiling 22's dodecagons fall off more slowly (measured: by half the square root of 3).
pub(super) fn sides(polygon: &[Point], falloff: f64, flat: bool) -> Sides {
    let n = polygon.len();
    let area: f64 = (0..n).map(|i| polygon[i][0] * polygon[(i + 1) % n][1] - polygon[(i + 1) % n][0] * polygon[i][1]).sum();
    (0..n)
        .map(|i| {
            let (a, b) = (polygon[i], polygon[(i + 1) % n]);
            let (dx, dz) = (b[0] - a[0], b[1] - a[1]);
            let slow = if flat && n == 12 && (dx.abs() < 1e-9 || dz.abs() < 1e-9 && dx > 0.0) { A } else { 1.0 };
            let k = area.signum() * slow / (dx.hypot(dz) * falloff);
            [-dz * k, dx * k, (dz * a[0] - dx * a[1]) * k]
        })
        .collect()
}

fn regular(n: u32, center: Point, angle: f64) -> Vec<Point> {
    let radius = 0.5 / (PI / f64::from(n)).sin();
    (0..n)
        .map(|i| {
            let (s, c) = (angle + 2.0 * PI * f64::from(i) / f64::from(n)).sin_cos();
            [center[0] + radius * c, center[1] + radius * s]
        })
        .collect()
}

fn rectangle(x0: f64, x1: f64, z0: f64, z1: f64) -> Vec<Point> {
    vec![[x0, z0], [x1, z0], [x1, z1], [x0, z1]]
}

fn hexagon(x: f64, z: f64) -> Vec<Point> {
    regular(6, [x, z], 0.0)
}

/// A dodecagon with a side at the bottom.
fn dodecagon(x: f64, z: f64) -> Vec<Point> {
    regular(12, [x, z], PI / 12.0)
}

/// A square two of whose sides run at right angles to `angle`.
fn square(x: f64, z: f64, angle: f64) -> Vec<Point> {
    regular(4, [x, z], angle + FRAC_PI_2 / 2.0)
}

/// Standing on its side from `x` to `x + 1`.
fn up(x: f64, z: f64) -> Vec<Point> {
    vec![[x, z], [x + 1.0, z], [x + 0.5, z + A]]
}

/// Hanging from its side from `x` to `x + 1`.
fn down(x: f64, z: f64) -> Vec<Point> {
    vec![[x, z], [x + 1.0, z], [x + 0.5, z - A]]
}

fn mirror_x(p: &[Point]) -> Vec<Point> {
    p.iter().map(|q| [-q[0], q[1]]).collect()
}

fn mirror_z(p: &[Point]) -> Vec<Point> {
    p.iter().map(|q| [q[0], -q[1]]).collect()
}

fn plan(n: u8) -> Plan {
    let make = |kinds, falloff, u, v, tiles| Plan { kinds, falloff, lattice: [u, v], tiles };
    // Half the diagonal of a square; steps of lattices.
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let (g, w) = (0.5 + A, 1.5 + A);
    match n {
        2 => make(1, A, [3.0, 0.0], [1.5, A], vec![(0, hexagon(-1.0, 0.0))]),
        3 => make(2, T, [1.0, 0.0], [0.5, A], vec![(0, up(0.0, 0.0)), (1, down(-0.5, A))]),
        4 => make(1, A / 2.0, [1.0, 0.0], [0.5, A], vec![(0, vec![[-1.0, 0.0], [0.0, 0.0], [0.5, A], [-0.5, A]])]),
        5 => {
            let right = vec![[0.0, 0.0], [0.5, A], [1.5, A], [1.0, 0.0]];
            let tiles = vec![(1, vec![[0.0, 0.0], [0.5, A], [0.0, 2.0 * A], [-0.5, A]]), (2, mirror_x(&right)), (0, right)];
            make(3, A / 2.0, [1.5, A], [0.0, 2.0 * A], tiles)
        }
        6 => make(2, 0.5, [1.0, 1.0], [2.0, -2.0], vec![(1, rectangle(-1.0, 0.0, -1.0, 1.0)), (0, rectangle(0.0, 2.0, -1.0, 0.0))]),
        7 => {
            let s = 1.0 + 2.0 * h;
            make(2, 0.5, [s, 0.0], [0.0, s], vec![(1, regular(8, [0.0, 0.0], PI / 8.0)), (0, regular(4, [s / 2.0, s / 2.0], 0.0))])
        }
        8 => {
            let tiles = vec![(0, up(-0.5, -A)), (1, down(0.0, 0.0)), (2, rectangle(0.0, 1.0, 0.0, 1.0))];
            make(3, T, [1.0, 0.0], [0.5, 1.0 + A], tiles)
        }
        9 => make(3, T, [2.0, 0.0], [1.0, 2.0 * A], vec![(0, up(-1.0, 0.0)), (1, down(0.0, 0.0)), (2, hexagon(0.5, A))]),
        10 => make(1, 0.5, [1.0, 0.0], [0.5, 1.0], vec![(0, rectangle(-0.5, 0.5, -1.0, 0.0))]),
        11 => {
            let tiles = vec![
                (2, rectangle(0.0, 1.0, 0.0, 2.0)),
                (1, rectangle(-2.0, 0.0, 0.0, 1.0)),
                (2, rectangle(-1.0, 0.0, -2.0, 0.0)),
                (1, rectangle(0.0, 2.0, -1.0, 0.0)),
                (0, rectangle(1.0, 2.0, 1.0, 2.0)),
            ];
            make(3, 0.5, [3.0, 0.0], [0.0, 3.0], tiles)
        }
        12 => {
            let mut tiles = vec![(0, rectangle(1.0, 2.0, 1.0, 2.0)), (0, rectangle(1.0, 2.0, -2.0, -1.0))];
            for (x, z) in [(-1.0, -2.0), (-1.0, 0.0), (0.0, -2.0), (0.0, 0.0)] {
                tiles.push((2, rectangle(x, x + 1.0, z, z + 2.0)));
            }
            for (x, z) in [(-3.0, -1.0), (-3.0, 0.0), (1.0, -1.0), (1.0, 0.0)] {
                tiles.push((1, rectangle(x, x + 2.0, z, z + 1.0)));
            }
            make(3, 0.5, [3.0, 3.0], [3.0, -3.0], tiles)
        }
        13 | 14 => {
            let s = 4.0 * h;
            let upright = vec![[0.0, 0.0], [h, h], [h, s - h], [0.0, s]];
            let lying = vec![[0.0, 0.0], [s, 0.0], [s - h, h], [h, h]];
            let inner = rectangle(h, s - h, h, s - h);
            let kinds = if n == 13 { [2, 2, 1, 1, 0] } else { [1, 0, 2, 3, 4] };
            let polygons = [upright.clone(), mirror_x(&upright), lying.clone(), mirror_z(&lying), inner];
            make(if n == 13 { 3 } else { 5 }, h / 2.0, [s, 0.0], [0.0, s], kinds.into_iter().zip(polygons).collect())
        }
        15 => make(2, 0.5, [2.0, 1.0], [1.0, -2.0], vec![(0, rectangle(0.0, 1.0, 0.0, 1.0)), (1, rectangle(-1.0, 1.0, -2.0, 0.0))]),
        16 | 17 => {
            let tilted = vec![[0.0, 0.0], [A, 0.5], [A - 0.5, g], [-0.5, A]];
            let polygons = [
                hexagon(-1.0, 0.0),
                vec![[0.0, 0.0], [A, 0.5], [A, -0.5]],
                vec![[A - 0.5, g], [-0.5, A], [-0.5, 1.0 + A]],
                mirror_z(&tilted),
                tilted,
                rectangle(A, 1.0 + A, -0.5, 0.5),
            ];
            let kinds = if n == 16 { [2, 1, 1, 0, 0, 0] } else { [5, 4, 3, 2, 1, 0] };
            make(if n == 16 { 3 } else { 6 }, T, [w, g], [w, -g], kinds.into_iter().zip(polygons).collect())
        }
        18 => {
            let tiles = vec![
                (1, rectangle(0.0, 1.0, 0.0, 2.0)),
                (1, rectangle(1.0, 2.0, 0.0, 2.0)),
                (0, rectangle(-2.0, 0.0, 0.0, 1.0)),
                (0, rectangle(-2.0, 0.0, 1.0, 2.0)),
            ];
            make(2, 0.5, [2.0, 2.0], [2.0, -2.0], tiles)
        }
        19 => snub([-1.0, 0.0], [0.5, -3.0 * A], [2.5, -A]),
        20 => snub([0.5, -A], [0.5, 3.0 * A], [2.5, A]),
        21 => {
            let right = vec![[0.0, 0.5], [0.0, -0.5], [A, 0.0]];
            let top = vec![[-0.5, g], [0.5, g], [0.0, 0.5]];
            let tilted = vec![[0.0, 0.5], [A, 0.0], [g, A], [0.5, g]];
            let tiles = vec![(2, mirror_x(&right)), (0, right), (3, mirror_z(&top)), (1, top), (5, mirror_x(&tilted)), (4, tilted)];
            make(6, T, [g, g], [g, -g], tiles)
        }
        22 => {
            let d = 2.0 + 2.0 * A;
            let tiles = vec![(0, up(-0.5, 0.5)), (1, down(-d / 2.0 - 0.5, 0.0)), (2, dodecagon(0.0, -g))];
            make(3, T, [d, 0.0], [d / 2.0, d * A], tiles)
        }
        23 | 24 => {
            let e = 3.0 + 2.0 * A;
            let polygons = [
                hexagon(0.0, g),
                hexagon(e / 2.0, 0.0),
                dodecagon(0.0, -g),
                square(e / 4.0, e * A / 6.0, FRAC_PI_3),
                square(-e / 4.0, e * A / 6.0, 2.0 * FRAC_PI_3),
                square(e / 2.0, -g, 0.0),
            ];
            let kinds = if n == 23 { [0, 0, 2, 1, 1, 1] } else { [0, 0, 4, 2, 3, 1] };
            make(if n == 23 { 3 } else { 5 }, 0.5, [e, 0.0], [e / 2.0, e * A], kinds.into_iter().zip(polygons).collect())
        }
        // 1, and what has no plan.
        _ => make(1, 0.5, [1.0, 0.0], [0.0, 1.0], vec![(0, rectangle(0.0, 1.0, 0.0, 1.0))]),
    }
}

/// Hexagons in a net of triangles, whose points of both ways are the kinds.
fn snub(center: Point, u: Point, v: Point) -> Plan {
    let mut tiles: Vec<Tile> = vec![(2, hexagon(center[0], center[1]))];
    let det = u[0] * v[1] - u[1] * v[0];
    let mut known: Vec<(u8, [i64; 2])> = Vec::new();
    let mut net: Vec<(f64, u8, Vec<Point>)> = Vec::new();
    for row in -6i32..=6 {
        for column in -8i32..=8 {
            let (x, z) = (f64::from(column) + 0.5 * f64::from(row.rem_euclid(2)), f64::from(row) * A);
            for (kind, polygon) in [(0, up(x, z)), (1, down(x, z))] {
                let middle: Point = std::array::from_fn(|c| polygon.iter().map(|q| q[c]).sum::<f64>() / 3.0 - center[c]);
                net.push((middle[0].hypot(middle[1]), kind, polygon));
            }
        }
    }
    net.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, kind, polygon) in net {
        let [x, z]: Point = std::array::from_fn(|c| polygon.iter().map(|q| q[c]).sum::<f64>() / 3.0 - center[c]);
        let (a, b) = ((x * v[1] - z * v[0]) / det, (u[0] * z - u[1] * x) / det);
        // Within a hexagon of the lattice?
        let covered = (-6..=6).any(|i| {
            (-6..=6).any(|j| {
                let (i, j) = (f64::from(i), f64::from(j));
                (x - i * u[0] - j * v[0]).hypot(z - i * u[1] - j * v[1]) < 0.8
            })
        });
        let fraction = |c: f64| ((c - (c + 1e-6).floor()) * 1000.0).round() as i64;
        let place = (kind, [fraction(a), fraction(b)]);
        if !covered && !known.contains(&place) {
            known.push(place);
            tiles.push((kind, polygon));
        }
    }
    Plan { kinds: 3, falloff: T, lattice: [u, v], tiles }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_lies_in_a_tile_and_neighbours_agree_on_their_sides() {
        for n in 1..=N_TILINGS {
            let t = &TILINGS[usize::from(n) - 1];
            // Areas of one cell's tiles add up to the cell.
            let p = plan(n);
            let [u, v] = p.lattice;
            let area = |q: &[Point]| {
                (0..q.len()).map(|i| q[i][0] * q[(i + 1) % q.len()][1] - q[(i + 1) % q.len()][0] * q[i][1]).sum::<f64>().abs() / 2.0
            };
            let sum: f64 = p.tiles.iter().map(|(_, q)| area(q)).sum();
            assert!((sum - (u[0] * v[1] - u[1] * v[0]).abs()).abs() < 1e-9, "tiling {n}: {sum}");
            for k in 0..400 {
                let (a, b) = (f64::from(k % 20) / 20.0 + 0.013, f64::from(k / 20) / 20.0 + 0.017);
                let (x, z) = (a * u[0] + b * v[0], a * u[1] + b * v[1]);
                let inside = |s: &Sides| s.iter().all(|s| s[0] * x + s[1] * z + s[2] >= -1e-9);
                assert!(t.tiles.iter().any(|(_, s)| inside(s)), "tiling {n}: nothing at ({x}, {z})");
            }
        }
    }
}
