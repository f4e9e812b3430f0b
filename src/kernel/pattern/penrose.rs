//! Penrose's tilings of the x, z plane: pentagons, stars, boats and rhombs (P1, tiling 25), kites and darts (P2, 26), and thick and thin
//! rhombs (P3, 27), each the one that five turns and a mirror leave as it is.
//!
//! Every tile of P2 and P3 is two triangles that mirror each other, and every such triangle is made of two or three smaller ones (R. M.
//! Robinson; Grünbaum and Shephard, Tilings and Patterns, 1987, section 10.3). So a point is followed down from a triangle at the origin that is large enough to
//! hold it: twenty steps reach any point within ten thousand units. P1's tiles lie in the triangles of a P3 of larger rhombs, in the same way in all of a kind.
//!
//! Which P1, P2 and P3 these are, where they stand and how values fall off was measured on the installed program, on 12,000 points within 30 units.

use super::tiling::{Point, Tile, sides};
use crate::math::EPSILON;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// The golden ratio.
pub const PHI: f64 = 1.618_033_988_749_895;
/// Distance of the middles of two pentagons of side 1 that share a side, and a star's radius.
const PENTAGONS: f64 = 1.376_381_920_471_173_4;
const FIFTH: f64 = PI / 5.0;

/// How triangles are made of smaller ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Halves of thin (flat = false) and thick (flat = true) rhombs: the sides from the first corner are the tile's.
    Rhombs,
    /// Halves of kites (flat = false) and darts (flat = true): likewise.
    Kites,
}

/// A side of a tile: a point's distance inwards, in falloffs, is `x * line[0] + z * line[1] + line[2]`. It counts where both guards are not negative:
/// beside a corner that points inwards, on the side's own half of the corner's angle.
#[derive(Clone, Copy, Debug)]
pub struct Side {
    /// Distance inwards.
    pub line: [f64; 3],
    /// Where the side counts.
    pub guards: [[f64; 3]; 2],
}

/// An aperiodic tiling.
#[derive(Debug)]
pub struct Penrose {
    /// Number of kinds of tiles.
    pub kinds: f64,
    /// How triangles are made.
    pub rule: Rule,
    /// The longer equal sides of a triangle of the last step: two sides of a rhomb, or a kite's long side and axis.
    pub side: f64,
    /// The triangle at the origin before a number of steps that four divides: whether it is flat, and its corners in units of its `side`.
    pub start: (bool, [Point; 3]),
    /// The tiles in a triangle that is not flat and in one that is: first corner at the origin, second on the x axis, third above it.
    pub tiles: [Vec<(f64, Vec<Side>)>; 2],
}

/// A guard that lets all through.
const ALWAYS: [f64; 3] = [0.0, 0.0, 1.0];

static PENROSE: LazyLock<[Penrose; 3]> = LazyLock::new(|| [Penrose::pentagons(), Penrose::kites(), Penrose::rhombs()]);

/// Tiling 25, 26 or 27.
pub fn penrose_plan(n: u8) -> Option<&'static Penrose> {
    PENROSE.get(usize::from(n).checked_sub(25)?)
}

/// The value of a tiling at x and z, 0..=1.
pub fn penrose(p: Point, t: &Penrose) -> f64 {
    let r = p[0].hypot(p[1]);
    if r < EPSILON {
        return 1.0;
    }
    let q = folded(p);
    let n_steps = n_steps(r / t.side);
    let (mut flat, mut corners) = t.start;
    let size = t.side * PHI.powi(n_steps);
    corners.iter_mut().flatten().for_each(|c| *c *= size);
    for _ in 0..n_steps {
        (flat, corners) = smaller(t.rule, flat, corners, q);
    }
    let [a, b, c] = corners;
    let length = (b[0] - a[0]).hypot(b[1] - a[1]);
    let e = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
    let (dx, dz) = (q[0] - a[0], q[1] - a[1]);
    let local = [dx * e[0] + dz * e[1], (dz * e[0] - dx * e[1]) * cross(a, b, c).signum()];
    let mut deepest = (f64::NEG_INFINITY, 0.0);
    for (kind, sides) in &t.tiles[usize::from(flat)] {
        let depth = depth(sides, local);
        if depth > deepest.0 {
            deepest = (depth, value(*kind, depth, t.kinds));
        }
        if depth > EPSILON {
            break;
        }
    }
    deepest.1
}

/// The value of a kind of tile at a depth. Where the parts of two kinds meet, both stay a little within theirs, so that a step of a map there does not show
/// (measured: 1e-6).
fn value(kind: f64, depth: f64, kinds: f64) -> f64 {
    let margin = |bound: f64| if bound > 0.0 && bound < kinds { 1e-6 } else { 0.0 };
    ((kind + 1.0 - depth) / kinds).clamp(kind / kinds + margin(kind), (kind + 1.0) / kinds - margin(kind + 1.0))
}

fn depth(sides: &[Side], p: Point) -> f64 {
    let at = |l: &[f64; 3]| l[0] * p[0] + l[1] * p[1] + l[2];
    sides.iter().filter(|s| s.guards.iter().all(|g| at(g) >= 0.0)).map(|s| at(&s.line)).fold(f64::INFINITY, f64::min)
}

/// The point between 0 and 36° that turns by 72° and the mirrors make of `p`.
fn folded(p: Point) -> Point {
    let upper = [p[0], p[1].abs()];
    [3.0, 2.0, 1.0].iter().fold(upper, |q, &fifths| {
        let u = polar(1.0, fifths);
        let along = 2.0 * (q[0] * u[0] + q[1] * u[1]);
        if cross([0.0; 2], u, q) > 0.0 { [along * u[0] - q[0], along * u[1] - q[1]] } else { q }
    })
}

/// Steps down from a triangle that holds all points of its corner at the origin within `r` sides of the last step's triangle, four, eight or more: the triangle at
/// the origin is the same after four.
fn n_steps(r: f64) -> i32 {
    // Triangles at the origin reach 0.951 of their side at least.
    4 * ((r / 0.95).ln() / PHI.powi(4).ln()).ceil().clamp(0.0, 250.0) as i32
}

/// The z of the product of `b - a` and `c - a`.
fn cross(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The point that divides `a` to `b` by the golden ratio, the longer part first.
fn golden(a: Point, b: Point) -> Point {
    [a[0] + (b[0] - a[0]) / PHI, a[1] + (b[1] - a[1]) / PHI]
}

/// The smaller triangle at `p` (or the nearest, where rounding leaves `p` between them).
fn smaller(rule: Rule, flat: bool, [a, b, c]: [Point; 3], p: Point) -> (bool, [Point; 3]) {
    let parts: &[(bool, [Point; 3])] = &match (rule, flat) {
        (Rule::Rhombs, false) => {
            let d = golden(a, b);
            [(false, [c, d, b]), (true, [d, c, a]), (true, [d, c, a])]
        }
        (Rule::Rhombs, true) => {
            let (d, e) = (golden(b, a), golden(b, c));
            [(true, [e, c, a]), (true, [d, e, b]), (false, [e, d, a])]
        }
        (Rule::Kites, false) => {
            let (d, e) = (golden(a, b), golden(b, c));
            [(true, [e, d, b]), (false, [d, a, e]), (false, [c, a, e])]
        }
        (Rule::Kites, true) => {
            let d = golden(c, a);
            [(true, [b, d, a]), (false, [d, c, b]), (false, [d, c, b])]
        }
    };
    let within = |t: &[Point; 3]| {
        let o = cross(t[0], t[1], t[2]).signum();
        (0..3).map(|i| o * cross(t[i], t[(i + 1) % 3], p)).fold(f64::INFINITY, f64::min)
    };
    *parts.iter().max_by(|s, t| within(&s.1).total_cmp(&within(&t.1))).expect("three parts")
}

fn polar(r: f64, fifths: f64) -> Point {
    let (s, c) = (fifths * FIFTH).sin_cos();
    [r * c, r * s]
}

fn sum(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1]]
}

impl Penrose {
    fn rhombs() -> Self {
        // How far values fall off, as in P1 (measured: 3.430088637).
        let falloff = PHI / 5.55;
        let half = |angle: f64, kind: f64| vec![(kind, two_sides(angle, falloff))];
        Self {
            kinds: 2.0,
            rule: Rule::Rhombs,
            side: 1.0,
            start: (true, [[1.0, 0.0], polar(PHI, 1.0), [0.0; 2]]),
            tiles: [half(FIFTH, 1.0), half(3.0 * FIFTH, 0.0)],
        }
    }

    fn kites() -> Self {
        let falloff = 1.0 / 4.46;
        let half = |angle: f64, kind: f64| vec![(kind, two_sides(angle, falloff))];
        Self {
            kinds: 2.0,
            rule: Rule::Kites,
            side: 1.0,
            start: (false, [polar(1.0, 1.0), [0.0; 2], [1.0, 0.0]]),
            tiles: [half(2.0 * FIFTH, 0.0), half(FIFTH, 1.0)],
        }
    }

    fn pentagons() -> Self {
        let falloff = PHI / 5.55;
        let l = PENTAGONS * PHI * PHI;
        let o = [0.0; 2];
        let pentagon = |kind: u8, center: Point, fifths: f64| -> Tile {
            (kind, (0..5).map(|i| sum(center, polar(0.5 / FIFTH.sin(), fifths + 2.0 * f64::from(i)))).collect())
        };
        // Every tenth of a turn a point outwards or a corner inwards; a boat lacks two points and the corner between them.
        let star = |kind: u8, center: Point, fifths: f64, tenths: &[i32]| -> Tile {
            let corner = |k: i32| polar(if k % 2 == 0 { PENTAGONS } else { PENTAGONS / (PHI * PHI) }, fifths + f64::from(k));
            (kind, tenths.iter().map(|&k| sum(center, corner(k))).collect())
        };
        let rhomb = |center: Point| -> Tile {
            let (x, z) = ((FIFTH / 2.0).cos(), (FIFTH / 2.0).sin());
            (5, [[-x, 0.0], [0.0, -z], [x, 0.0], [0.0, z]].map(|q| sum(center, q)).to_vec())
        };
        let whole: Vec<i32> = (0..10).collect();
        let (b, step) = ([l, 0.0], |from: Point, fifths: f64| sum(from, polar(PENTAGONS, fifths)));
        let tip = polar(l, 1.0);
        let thin = [
            pentagon(0, o, 0.0),
            pentagon(0, b, 1.0),
            pentagon(2, step(o, 1.0), 1.0),
            pentagon(1, step(b, 4.0), 0.0),
            rhomb([l / 2.0, 0.0]),
            star(3, tip, 0.0, &whole),
        ];
        let tip = polar(l, 3.0);
        let thick = [
            pentagon(0, o, 0.0),
            pentagon(0, b, 1.0),
            pentagon(1, step(o, 1.0), 1.0),
            pentagon(2, step(b, 4.0), 0.0),
            pentagon(2, step(o, 3.0), 1.0),
            pentagon(1, step(tip, -1.0), 0.0),
            rhomb([l / 2.0, 0.0]),
            star(4, sum(tip, polar(l / PHI, -1.0)), -1.0, &[0, 1, 2, 3, 7, 8, 9]),
            star(3, tip, 0.0, &whole),
        ];
        let ready = |tiles: &[Tile]| tiles.iter().map(|(kind, polygon)| (f64::from(*kind), guarded(polygon, falloff))).collect();
        Self {
            kinds: 6.0,
            rule: Rule::Rhombs,
            side: l,
            start: (true, [polar(1.0, 1.0), o, [PHI, 0.0]]),
            tiles: [ready(&thin), ready(&thick)],
        }
    }
}

/// The sides of a tile at the first corner of its half, whose angle this is. The other half's are never nearer.
fn two_sides(angle: f64, falloff: f64) -> Vec<Side> {
    let (s, c) = angle.sin_cos();
    [[0.0, 1.0, 0.0], [s, -c, 0.0]].map(|l| Side { line: l.map(|v| v / falloff), guards: [ALWAYS; 2] }).to_vec()
}

/// The sides of a polygon that goes around the way from x to z.
fn guarded(polygon: &[Point], falloff: f64) -> Vec<Side> {
    let n = polygon.len();
    let unit = |a: Point, b: Point| {
        let l = (b[0] - a[0]).hypot(b[1] - a[1]);
        [(b[0] - a[0]) / l, (b[1] - a[1]) / l]
    };
    // What divides the angle at corner `i`, where it points inwards: positive on the half of the side that ends there.
    let divides = |i: usize| {
        let (before, at, after) = (polygon[(i + n - 1) % n], polygon[i], polygon[(i + 1) % n]);
        let (u, v) = (unit(before, at), unit(at, after));
        let d = [u[0] - v[0], u[1] - v[1]];
        let left = [-d[1], d[0], d[1] * at[0] - d[0] * at[1]];
        (cross(before, at, after) < -EPSILON).then_some(left)
    };
    sides(polygon, falloff, false)
        .into_iter()
        .enumerate()
        .map(|(i, line)| {
            let start = divides(i).map_or(ALWAYS, |g| g.map(|v| -v));
            Side { line, guards: [start, divides((i + 1) % n).unwrap_or(ALWAYS)] }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_the_plane_and_turns_leave_them() {
        for n in 25..=27 {
            let t = penrose_plan(n).expect("a tiling");
            for k in 0..2000 {
                let (r, turn) = (0.05 * f64::from(k) + 0.013, 0.777 * f64::from(k));
                let at = |turn: f64| penrose([r * turn.cos(), r * turn.sin()], t);
                let value = at(turn);
                for other in [at(turn + 2.0 * FIFTH), at(-turn)] {
                    // Beside a side rounding may choose the other tile.
                    assert!((value - other).abs() < 1e-6 || (value * t.kinds).fract() < 1e-6 || (other * t.kinds).fract() < 1e-6);
                }
            }
        }
    }
}
