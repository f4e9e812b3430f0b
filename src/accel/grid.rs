//! Grids: cells of equal size, each with what it touches; in a hierarchical one a cell that holds much is a grid itself.
//! The build stands in `accel/grid_build.rs`.
//!
//! A ray walks from cell to cell (Amanatides, Woo 1987); where it leaves a cell is worked out from the cell's place, so that errors do not
//! add up. A primitive lies in a block of cells, and a ray crosses a block in one stretch: it is new in a cell exactly when the cell
//! before was outside the block. That is the cure for repeated tests; it remembers nothing and forgets nothing.

use super::{AccelStats, BoxF, can_meet};
use crate::math::Ray;

/// In [`GridCell::count`]: the cell is a grid, and `first` is its number.
pub const GRID_INNER: u32 = u32::MAX;
/// Grids in grids, at most.
pub const GRID_LEVELS: usize = 3;
/// Most cells along an axis: three indices fit a word.
pub const GRID_SIDE: u32 = 1 << 10;

/// A grid; all cells of all grids stand in one array.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridBox {
    /// Lower corner.
    pub lo: [f32; 3],
    /// Size of a cell.
    pub size: [f32; 3],
    /// Cells along each axis, 1 to 1024.
    pub n: [u32; 3],
    /// Cell (0, 0, 0); x runs fastest.
    pub first_cell: u32,
}

/// A cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct GridCell {
    /// First of its places in [`Grid::lists`], or the number of its grid.
    pub first: u32,
    /// How many, or [`GRID_INNER`].
    pub count: u32,
}

/// A primitive in a grid, with the block of cells that it lies in; indices as [`pack_cell`] has them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridEntry {
    /// Which.
    pub prim: u32,
    /// Lowest cell.
    pub lo: u32,
    /// Highest cell.
    pub hi: u32,
}

/// A uniform or hierarchical grid.
#[derive(Clone, Debug)]
pub struct Grid {
    /// Grids, the outermost first; none for no primitives.
    pub grids: Vec<GridBox>,
    /// Cells of them all.
    pub cells: Vec<GridCell>,
    /// What the cells hold, into `entries`.
    pub lists: Vec<u32>,
    /// Primitives in their grids.
    pub entries: Vec<GridEntry>,
    /// Box of all primitives.
    pub bounds: BoxF,
    /// Grids in grids: 1 for a uniform one.
    pub n_levels: usize,
    /// What came of the build.
    pub stats: AccelStats,
}

/// Three cell indices in a word.
#[inline]
pub fn pack_cell(c: [u32; 3]) -> u32 {
    c[0] | c[1] << 10 | c[2] << 20
}

#[inline]
fn unpack_cell(c: u32) -> [i32; 3] {
    [0, 10, 20].map(|s| (c >> s & 1023) as i32)
}

/// A walk through one grid.
#[derive(Clone, Copy)]
struct Walk {
    grid: u32,
    cell: [i32; 3],
    t_exit: f64,
}

/// A cell that no block holds.
const NOWHERE: [i32; 3] = [-1; 3];

impl Grid {
    /// Visits cells along the ray in order; `visit(prim, t_max)` is asked for each primitive that is new, and gives the depth that still
    /// matters or `None` to stop. Tells whether it stopped.
    #[inline]
    pub(super) fn walk(&self, ray: &Ray, t_min: f64, t_max: f64, mut visit: impl FnMut(u32, f64) -> Option<f64>) -> bool {
        if self.grids.is_empty() || !can_meet(ray, t_min, t_max) {
            return false;
        }
        let slabs = super::slabs::SlabRay::new(ray, self.bounds.max_abs());
        let (enter, exit) = slabs.clip(&self.bounds, t_min.max(0.0), t_max);
        if !(enter <= exit) {
            return false;
        }
        let (o, d): ([f64; 3], [f64; 3]) = (ray.origin.into(), ray.dir.into());
        let start = |grid: u32, t: f64, t_exit: f64| {
            let g = &self.grids[grid as usize];
            let cell = std::array::from_fn(|k| {
                let at = (o[k] + t * d[k] - f64::from(g.lo[k])) / f64::from(g.size[k]);
                (at.floor() as i32).clamp(0, g.n[k] as i32 - 1)
            });
            Walk { grid, cell, t_exit }
        };
        let mut best = t_max;
        let mut outer = [start(0, enter, exit); GRID_LEVELS];
        let (mut level, mut at, mut t, mut before) = (0, start(0, enter, exit), enter, NOWHERE);
        loop {
            let g = &self.grids[at.grid as usize];
            let cell = self.cells[g.first_cell as usize + g.index(at.cell)];
            let (axis, t_next) = g.way_out(at.cell, &o, &d, &slabs.inv);
            let t_out = t_next.min(at.t_exit);
            if cell.count == GRID_INNER {
                outer[level] = at;
                level += 1;
                at = start(cell.first, t, t_out);
                before = NOWHERE;
                continue;
            }
            for k in &self.lists[cell.first as usize..(cell.first + cell.count) as usize] {
                let e = &self.entries[*k as usize];
                let (lo, hi) = (unpack_cell(e.lo), unpack_cell(e.hi));
                if (0..3).all(|k| before[k] >= lo[k] && before[k] <= hi[k]) {
                    continue;
                }
                match visit(e.prim, best) {
                    Some(t) => best = t,
                    None => return true,
                }
            }
            // On to the next cell, out of all grids that end here.
            before = at.cell;
            let (mut axis, mut t_next) = (axis, t_next);
            loop {
                t = t.max(t_next.min(at.t_exit));
                if t > best {
                    return false;
                }
                at.cell[axis] += if d[axis] > 0.0 { 1 } else { -1 };
                let inside = at.cell[axis] >= 0 && at.cell[axis] < self.grids[at.grid as usize].n[axis] as i32;
                if inside && t_next <= at.t_exit {
                    break;
                }
                if level == 0 {
                    return false;
                }
                level -= 1;
                at = outer[level];
                // What the inner grid held was not all met.
                before = NOWHERE;
                (axis, t_next) = self.grids[at.grid as usize].way_out(at.cell, &o, &d, &slabs.inv);
            }
        }
    }

    /// Whether every number makes sense. For tests of uploads.
    pub fn is_sound(&self, n_prims: usize) -> bool {
        let cell_ok = |c: &GridCell| match c.count {
            GRID_INNER => (c.first as usize) < self.grids.len() && c.first > 0,
            n => c.first as usize + n as usize <= self.lists.len(),
        };
        self.cells.iter().all(cell_ok)
            && self.lists.iter().all(|k| (*k as usize) < self.entries.len())
            && self.entries.iter().all(|e| (e.prim as usize) < n_prims)
            && self.grids.iter().all(|g| g.first_cell as usize + g.n.iter().map(|n| *n as usize).product::<usize>() <= self.cells.len())
    }
}

impl GridBox {
    #[inline]
    fn index(&self, c: [i32; 3]) -> usize {
        let c = c.map(|v| v as usize);
        (c[2] * self.n[1] as usize + c[1]) * self.n[0] as usize + c[0]
    }

    /// Axis and depth where a ray leaves a cell.
    #[inline]
    fn way_out(&self, cell: [i32; 3], o: &[f64; 3], d: &[f64; 3], inv: &[f64; 3]) -> (usize, f64) {
        let mut out = (0, f64::INFINITY);
        for k in 0..3 {
            if d[k].abs() < 1e-280 {
                continue;
            }
            let side = f64::from(cell[k] + i32::from(d[k] > 0.0));
            let t = (f64::from(self.lo[k]) + side * f64::from(self.size[k]) - o[k]) * inv[k];
            if t < out.1 {
                out = (k, t);
            }
        }
        out
    }
}
