//! Pavements of the x, z plane by pieces of a few triangles, squares or hexagons of side 1 (polyominoes and their kin).
//!
//! A layout says which sides of the cells are seams between pieces; it repeats by a lattice. A cell is cut into parts, one a corner, and the value there is that of the seams at
//! the corner alone: 1 on them, less by `STEEPNESS` times the distance. `form`, `interior` and `exterior` say how corners are rounded or cut. Layouts
//! (`compile/texture/layouts.rs`) and formulas were measured on the installed program: 112 layouts at the middles of 1,000 sides each, corners at 35 places for all that meet in them.

use crate::compile::texture::{Layout, Pavement};

/// Half the square root of 3.
const A: f64 = 0.866_025_403_784_438_6;
/// How fast values fall off from a seam, by number of sides: to 0 at the middle of squares and triangles.
const fn steepness(sides: u8) -> f64 {
    if sides == 4 { 2.0 } else { 4.0 * A }
}

/// The value at x and z, 0..=1.
pub fn pavement(x: f64, z: f64, p: &Pavement) -> f64 {
    let value = match p.sides {
        4 => square(x, z, p),
        6 => hexagon(x, z, p),
        _ => triangle(x, z, p),
    };
    value.clamp(0.0, 1.0)
}

/// A corner that a circle of radius `r` around (`d`, 0) rounds, as steep as seams.
fn rounded(x: f64, z: f64, d: f64, r: f64, k: f64) -> f64 {
    1.0 - k * (r - (x - d).hypot(z))
}

fn square(x: f64, z: f64, p: &Pavement) -> f64 {
    let (i, j) = (x.floor(), z.floor());
    let (u, w) = (x - i, z - j);
    let (i, j) = (i as i64, j as i64);
    let (right, top) = (u >= 0.5, w >= 0.5);
    let upright = |i: i64, j: i64| p.layout.seam(i, j, 0);
    let level = |i: i64, j: i64| p.layout.seam(i, j, 1);
    let touched = |i: i64, j: i64| upright(i, j) || upright(i, j - 1) || level(i, j) || level(i - 1, j);
    let [left_seam, right_seam, low_seam, top_seam] = [upright(i, j), upright(i + 1, j), level(i, j), level(i, j + 1)];
    // A piece bends here, around the corner away from both seams: `form` says how, 3 leaves it to `interior` and `exterior`.
    let bends = left_seam != right_seam && low_seam != top_seam && touched(i + i64::from(left_seam), j + i64::from(low_seam));
    let far = [if left_seam { 1.0 - u } else { u }, if low_seam { 1.0 - w } else { w }];
    let (interior, exterior) = match p.form {
        1 if bends => return (2.0 * (far[0] + far[1] - 0.5)).abs(),
        2 if bends => return 2.0 * (far[0].hypot(far[1]) - 0.5).abs(),
        0 if bends => (0, 0),
        _ => (p.interior, p.exterior),
    };
    let (a, b) = (if right { 1.0 - u } else { u }, if top { 1.0 - w } else { w });
    match (if right { right_seam } else { left_seam }, if top { top_seam } else { low_seam }) {
        (true, true) => match exterior {
            1 => 2.0 - 2.0 * (a + b),
            2 => 2.0 * (0.5 - a).hypot(0.5 - b),
            _ => 1.0 - 2.0 * a.min(b),
        },
        (true, false) => 1.0 - 2.0 * a,
        (false, true) => 1.0 - 2.0 * b,
        (false, false) if !touched(i + i64::from(right), j + i64::from(top)) => 0.0,
        (false, false) => match interior {
            1 => 1.0 - 2.0 * (a + b),
            2 => 1.0 - 2.0 * a.hypot(b),
            _ => 1.0 - 2.0 * a.max(b),
        },
    }
}

/// One of the six sides at a point of the lattice of triangles, or of a hexagon, from the one along 0 (30)°.
fn side_of_six(layout: &Layout, i: i64, j: i64, turn: i64) -> bool {
    match turn.rem_euclid(6) {
        0 => layout.seam(i, j, 0),
        1 => layout.seam(i, j, 1),
        2 => layout.seam(i, j, 2),
        3 => layout.seam(i - 1, j, 0),
        4 => layout.seam(i, j - 1, 1),
        _ => layout.seam(i + 1, j - 1, 2),
    }
}

fn triangle(x: f64, z: f64, p: &Pavement) -> f64 {
    let k = steepness(3);
    let row = z / A;
    let column = x - 0.5 * row;
    let (i, j) = (column.floor(), row.floor());
    let (f, g) = (column - i, row - j);
    let (i, j) = (i as i64, j as i64);
    // Corners with their weights, and the turn from 30° to the middle, in sixths.
    let corners = if f + g < 1.0 {
        [(1.0 - f - g, i, j, 0), (f, i + 1, j, 2), (g, i, j + 1, 4)]
    } else {
        [(f + g - 1.0, i + 1, j + 1, 3), (1.0 - f, i, j + 1, 5), (1.0 - g, i + 1, j, 1)]
    };
    let (_, i, j, turn) = corners.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)).expect("three corners");
    let spoke = |m: i64| side_of_six(&p.layout, i, j, turn + m);
    // From the corner: along the way to the middle, and across.
    let (dx, dz) = (x - (i as f64 + 0.5 * j as f64), z - A * j as f64);
    let (s, c) = (std::f64::consts::FRAC_PI_6 * (1 + 2 * turn) as f64).sin_cos();
    let (along, across) = (dx * c + dz * s, dz * c - dx * s);
    let (low, high) = (0.5 * along + A * across, 0.5 * along - A * across);
    match (spoke(0), spoke(1)) {
        (true, true) => {
            let sharp = 1.0 - k * low.min(high);
            match p.exterior {
                1 => sharp.max(2.0 - k * along),
                2 => rounded(along, across, 0.5 / A, 0.25 / A, k),
                _ => sharp,
            }
        }
        // The corner of two cells, whose middle is the side between them.
        (true, false) if p.form > 0 && spoke(2) => bend(A * along + 0.5 * across, A * across - 0.5 * along, p.form, k),
        (false, true) if p.form > 0 && spoke(-1) => bend(A * along - 0.5 * across, A * across + 0.5 * along, p.form, k),
        (true, false) => 1.0 - k * low,
        (false, true) => 1.0 - k * high,
        (false, false) if (0..6).all(|m| !spoke(m)) => 0.0,
        (false, false) => match p.interior {
            1 => 1.0 - 3.0 * (A * along + 0.5 * across.abs()),
            2 => 1.0 - 3.0 * along.hypot(across),
            _ => 1.0 - k * along,
        },
    }
}

/// A corner of 120°, cut or rounded; along its middle and across.
fn bend(along: f64, across: f64, form: u8, k: f64) -> f64 {
    if form == 1 { 2.0 - 4.0 * along } else { rounded(along, across, 1.0, A, k) }
}

fn hexagon(x: f64, z: f64, p: &Pavement) -> f64 {
    let k = steepness(6);
    let column = (x - 1.0) / 1.5;
    let row = (z - A * column) / (2.0 * A);
    let middle = |i: f64, j: f64| [1.0 + 1.5 * i, A * i + 2.0 * A * j];
    let near = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(a, b)| {
        let (i, j) = (column.floor() + a, row.floor() + b);
        let m = middle(i, j);
        ((x - m[0]).hypot(z - m[1]), i, j)
    });
    let (_, i, j) = near.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).expect("four cells");
    let m = middle(i, j);
    let turn = ((z - m[1]).atan2(x - m[0]) / std::f64::consts::FRAC_PI_3).round();
    let (i, j, turn) = (i as i64, j as i64, turn as i64);
    // From the corner: along the way to the middle, and across.
    let (s, c) = (std::f64::consts::FRAC_PI_3 * turn as f64).sin_cos();
    let (dx, dz) = (x - m[0] - c, z - m[1] - s);
    let (along, across) = (-dx * c - dz * s, dx * s - dz * c);
    let inwards = |across: f64| match p.interior {
        1 if across > 0.0 => 1.0 - 3.0 * along.max(0.5 * along + A * across),
        2 if across > 0.0 => 1.0 - 3.0 * along.hypot(across),
        _ => 1.0 - k * (A * along + 0.5 * across),
    };
    match (side_of_six(&p.layout, i, j, turn - 1), side_of_six(&p.layout, i, j, turn)) {
        (true, true) if p.form > 0 => bend(along, across, p.form, k),
        (true, true) => 1.0 - k * (A * along - 0.5 * across.abs()),
        // The seam goes on away from the cell: the piece has an inward corner here.
        (true, false) => inwards(-across),
        (false, true) => inwards(across),
        (false, false) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::texture::layout_of;

    #[test]
    fn a_side_is_a_seam_of_both_its_cells() {
        // Just this side and just beyond of every side of many cells the value is the same, seam or not.
        for (sides, most) in [(3, 6), (4, 6), (6, 5)] {
            for tiles in 1..=most {
                for pattern in 1..=35 {
                    let p = Pavement { sides, interior: 0, exterior: 0, form: 0, layout: layout_of(sides, tiles, pattern) };
                    for n in 0..60 {
                        let (x, z) = (0.37 * f64::from(n) - 7.0, 0.91 * f64::from(n % 13) - 5.0);
                        let (a, b) = (pavement(x, z, &p), pavement(x + 1e-9, z + 1e-9, &p));
                        assert!((a - b).abs() < 1e-6, "{sides} {tiles} {pattern} at ({x}, {z}): {a} {b}");
                    }
                }
            }
        }
    }
}
