//! Building grids: a block of cells for each primitive, lists by counting; full cells of a hierarchical grid are divided again.
//!
//! Sources: Cleary, Wyvill 1988 (cells a primitive); Jevans, Wyvill 1989 (grids in grids).

use super::grid::{GRID_INNER, GRID_LEVELS, GRID_SIDE, Grid, GridBox, GridCell, GridEntry, pack_cell};
use super::{AccelOptions, AccelStats, BoxF, PrimRef, PrimSet, box_of, seconds_since, usable_prims};
use std::time::Instant;

/// Cells for each primitive: of a uniform grid; of the outermost of a hierarchical one; of those inside. Measured with `rayloom bench accel`.
const CELLS_PER_PRIM: [f64; 3] = [4.0, 0.5, 2.0];
/// A cell with more is divided.
const FULL_CELL: usize = 12;
/// Boxes are grown by these shares of the longest side and of the largest coordinate, so that 32-bit rays that run beside a cell's side find
/// what the side touches.
const PAD: [f32; 2] = [1e-5, 4e-7];
/// Entries of a grid for each primitive, twice or, with grids in its cells, four times as many.
const MAX_REFS_PER_PRIM: f64 = 12.0;
/// Cells of one grid.
const MAX_CELLS: f64 = (1 << 25) as f64;

struct Builder<'a, P> {
    prims: &'a P,
    out: Grid,
    pad: f32,
    /// References that all lists may hold together.
    spare: usize,
}

impl Grid {
    /// Builds over all primitives with usable bounds; `n_levels` is 1 for a uniform grid, up to [`GRID_LEVELS`].
    pub fn build(prims: &impl PrimSet, options: &AccelOptions, n_levels: usize) -> Self {
        let start = Instant::now();
        let refs = usable_prims(prims);
        let bounds = box_of(&refs);
        let (n, n_levels) = (refs.len(), n_levels.clamp(1, GRID_LEVELS));
        let (grids, cells, lists, entries) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let out = Grid { grids, cells, lists, entries, bounds, n_levels, stats: AccelStats::default() };
        let longest = (0..3).map(|k| bounds.hi[k] - bounds.lo[k]).fold(0.0, f32::max);
        let spare =
            (n as f64 * options.max_refs_per_prim.min(MAX_REFS_PER_PRIM) * if n_levels > 1 { 4.0 } else { 2.0 }).min(1e9) as usize + 4096;
        let mut b = Builder { prims, out, pad: PAD[0] * longest + PAD[1] * bounds.max_abs() as f32, spare };
        if n > 0 {
            b.grid(&refs, &bounds, 0);
        }
        let mut out = b.out;
        out.bounds = if n > 0 { grown(&bounds, b.pad) } else { bounds };
        let n_bytes = out.grids.len() * 48 + out.cells.len() * 8 + out.lists.len() * 4 + out.entries.len() * 16;
        out.stats = AccelStats {
            n_prims: prims.len(),
            n_skipped: prims.len() - n,
            n_nodes: out.grids.len(),
            n_leaves: out.cells.len(),
            n_refs: out.lists.len(),
            depth: n_levels,
            sah_cost: 0.0,
            build_seconds: seconds_since(start),
            n_bytes,
        };
        out
    }
}

fn grown(b: &BoxF, by: f32) -> BoxF {
    BoxF { lo: b.lo.map(|v| v - by), hi: b.hi.map(|v| v + by) }
}

impl<P: PrimSet> Builder<'_, P> {
    /// Appends the grid of `refs` over `cell`; gives its number.
    fn grid(&mut self, refs: &[PrimRef], cell: &BoxF, level: usize) -> u32 {
        let per_prim = if self.out.n_levels == 1 { CELLS_PER_PRIM[0] } else { CELLS_PER_PRIM[1 + level.min(1)] };
        let cell = grown(cell, self.pad);
        // Coarser, until what large primitives touch fits.
        let mut wanted = (per_prim * refs.len() as f64).clamp(1.0, MAX_CELLS);
        let (grid, blocks) = loop {
            let grid = divided(&cell, wanted, self.out.cells.len() as u32);
            let blocks: Vec<[[u32; 3]; 2]> = refs.iter().map(|r| grid.block(&grown(&r.bounds, self.pad))).collect();
            let n_refs: usize = blocks.iter().map(|[lo, hi]| (0..3).map(|k| (hi[k] - lo[k] + 1) as usize).product::<usize>()).sum();
            // The outermost of several leaves most of them to what is inside.
            let share = if level + 1 < self.out.n_levels { self.spare / 3 } else { self.spare };
            if n_refs <= share.max(refs.len()) || wanted <= 1.0 {
                self.spare = self.spare.saturating_sub(n_refs);
                break (grid, blocks);
            }
            wanted /= 2.0;
        };
        let number = self.out.grids.len() as u32;
        self.out.grids.push(grid);
        let n_cells: usize = grid.n.iter().map(|n| *n as usize).product();
        let mut starts = vec![0u32; n_cells + 1];
        let cells_of = |block: &[[u32; 3]; 2], visit: &mut dyn FnMut(usize)| {
            let [lo, hi] = block;
            for z in lo[2]..=hi[2] {
                for y in lo[1]..=hi[1] {
                    let row = (z as usize * grid.n[1] as usize + y as usize) * grid.n[0] as usize;
                    (lo[0]..=hi[0]).for_each(|x| visit(row + x as usize));
                }
            }
        };
        blocks.iter().for_each(|b| cells_of(b, &mut |c| starts[c + 1] += 1));
        for c in 0..n_cells {
            starts[c + 1] += starts[c];
        }
        let mut lists = vec![0u32; starts[n_cells] as usize];
        let mut next = starts.clone();
        for (k, block) in blocks.iter().enumerate() {
            cells_of(block, &mut |c| {
                lists[next[c] as usize] = k as u32;
                next[c] += 1;
            });
        }
        let (first_entry, first_list, first_cell) = (self.out.entries.len() as u32, self.out.lists.len() as u32, self.out.cells.len());
        let entry = |(r, [lo, hi]): (&PrimRef, &[[u32; 3]; 2])| GridEntry { prim: r.prim, lo: pack_cell(*lo), hi: pack_cell(*hi) };
        self.out.entries.extend(refs.iter().zip(&blocks).map(entry));
        self.out.lists.extend(lists.iter().map(|k| first_entry + k));
        self.out.cells.extend((0..n_cells).map(|c| GridCell { first: first_list + starts[c], count: starts[c + 1] - starts[c] }));
        if level + 1 < self.out.n_levels {
            for c in 0..n_cells {
                let list = &lists[starts[c] as usize..starts[c + 1] as usize];
                if list.len() > FULL_CELL
                    && n_cells > 1
                    && let Some(number) = self.inner(refs, list, &grid.cell_box(c), level + 1)
                {
                    self.out.cells[first_cell + c] = GridCell { first: number, count: GRID_INNER };
                }
            }
        }
        number
    }

    /// The grid of one full cell; `None` when it would not be finer.
    fn inner(&mut self, refs: &[PrimRef], list: &[u32], cell: &BoxF, level: usize) -> Option<u32> {
        let bounds = grown(cell, self.pad).to_bounds();
        let part = |k: &u32| {
            let r = refs[*k as usize];
            let clipped = BoxF::around(&self.prims.clipped_bounds(r.prim as usize, &bounds))?;
            // Clipping is exact to rounding only; the pad covers it.
            Some(PrimRef { bounds: clipped.intersection(&grown(&r.bounds, self.pad))?, prim: r.prim })
        };
        let parts: Vec<PrimRef> = list.iter().filter_map(part).collect();
        if parts.len() <= FULL_CELL / 2 || self.spare < parts.len() || cell_side(cell) < 64.0 * self.pad {
            return None;
        }
        Some(self.grid(&parts, cell, level))
    }
}

/// The shortest side.
fn cell_side(b: &BoxF) -> f32 {
    (0..3).map(|k| b.hi[k] - b.lo[k]).fold(f32::INFINITY, f32::min)
}

/// About `wanted` cells over a box, as near to cubes as may be.
fn divided(b: &BoxF, wanted: f64, first_cell: u32) -> GridBox {
    let sides: [f64; 3] = std::array::from_fn(|k| f64::from(b.hi[k]) - f64::from(b.lo[k]));
    let longest = sides.iter().fold(1e-30, |a: f64, s| a.max(*s));
    let sides = sides.map(|s| s.max(1e-4 * longest));
    let per_unit = (wanted / (sides[0] * sides[1] * sides[2])).cbrt();
    let n = sides.map(|s| ((s * per_unit).round().clamp(1.0, f64::from(GRID_SIDE))) as u32);
    // Rounded up, so that the last cell reaches the box's end.
    let size =
        std::array::from_fn(|k| (((f64::from(b.hi[k]) - f64::from(b.lo[k])) / f64::from(n[k])) as f32).next_up().max(f32::MIN_POSITIVE));
    GridBox { lo: b.lo, size, n, first_cell }
}

impl GridBox {
    /// Lowest and highest cell that a box touches; those at the ends reach on without end.
    fn block(&self, b: &BoxF) -> [[u32; 3]; 2] {
        let cell = |v: f32, k: usize| {
            let at = (f64::from(v) - f64::from(self.lo[k])) / f64::from(self.size[k]);
            (at.floor().max(0.0) as u32).min(self.n[k] - 1)
        };
        [std::array::from_fn(|k| cell(b.lo[k], k)), std::array::from_fn(|k| cell(b.hi[k], k))]
    }

    fn cell_box(&self, ix: usize) -> BoxF {
        let (nx, ny) = (self.n[0] as usize, self.n[1] as usize);
        let c = [ix % nx, ix / nx % ny, ix / nx / ny];
        let side = |k: usize, c: usize| self.lo[k] + c as f32 * self.size[k];
        BoxF { lo: std::array::from_fn(|k| side(k, c[k])), hi: std::array::from_fn(|k| side(k, c[k] + 1)) }
    }
}
