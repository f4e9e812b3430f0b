//! Which sides of the cells of pavements are seams, measured on the installed program at the middles of the sides (`kernel/pattern/pavement.rs` says how): by number of tiles, then
//! pattern.

/// Which sides of cells are seams: cells (i, j) of a lattice that (columns, 0) and (shift, rows) repeat, a digit each, row by row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// Period along a row.
    pub columns: i64,
    /// What a row `rows` further up is shifted by.
    pub shift: i64,
    /// Rows that repeat.
    pub rows: i64,
    /// Bits of the cell's own sides. Squares: left, bottom. Triangles (cells are the points of their lattice): sides from the point along 0, 60 and 120°.
    /// Hexagons: sides towards the neighbours at 30, 90 and 150°.
    pub digits: &'static str,
}

/// A pavement: its layout and what happens at corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pavement {
    /// Sides of a cell: 3, 4 or 6.
    pub sides: u8,
    /// Corners within a piece that point inwards.
    pub interior: u8,
    /// Corners at the ends of pieces.
    pub exterior: u8,
    /// Corners where pieces bend.
    pub form: u8,
    /// Seams.
    pub layout: Layout,
}

/// The layout of `pattern` (from 1, 0 is 1 too) for pieces of `tiles` cells.
pub fn layout_of(sides: u8, tiles: u8, pattern: u8) -> Layout {
    let of_tiles: &[&[Layout]] = match sides {
        4 => &SQUARES,
        6 => &HEXAGONS,
        _ => &TRIANGLES,
    };
    let list = of_tiles[usize::from(tiles.max(1) - 1).min(of_tiles.len() - 1)];
    list[usize::from(pattern.max(1) - 1).min(list.len() - 1)]
}

impl Layout {
    /// Whether a side of cell (i, j) is a seam, by its bit.
    pub fn seam(&self, i: i64, j: i64, side: u32) -> bool {
        let turns = j.div_euclid(self.rows);
        let (row, column) = (j - turns * self.rows, (i - turns * self.shift).rem_euclid(self.columns));
        let digit = self.digits.as_bytes()[(row * self.columns + column) as usize] - b'0';
        digit >> side & 1 == 1
    }
}

const fn l(columns: i64, shift: i64, rows: i64, digits: &'static str) -> Layout {
    Layout { columns, shift, rows, digits }
}

/// Pieces of 1 to 6 triangles.
#[rustfmt::skip]
const TRIANGLES: [&[Layout]; 6] = [
    &[l(1, 0, 1, "7")],
    &[l(1, 0, 1, "5")],
    &[l(3, 1, 1, "315")],
    &[l(2, 1, 1, "15"), l(2, 1, 1, "61"), l(2, 0, 2, "7124")],
    &[l(5, 2, 1, "31151"), l(5, 2, 1, "71212"), l(5, 2, 1, "55214"), l(5, 3, 1, "31270")],
    &[l(3, 0, 1, "311"), l(3, 0, 1, "251"), l(3, 1, 1, "251"), l(3, 1, 2, "711124"), l(3, 1, 2, "313230"), l(3, 2, 2, "331212"), l(2, 1, 3, "315412"),
      l(2, 1, 3, "314503"), l(3, 1, 2, "315214"), l(3, 0, 1, "305"), l(3, 1, 1, "314"), l(3, 1, 1, "205")],
];

/// Pieces of 1 to 6 squares.
#[rustfmt::skip]
const SQUARES: [&[Layout]; 6] = [
    &[l(1, 0, 1, "3")],
    &[l(1, 0, 2, "31")],
    &[l(3, 0, 1, "322"), l(3, 0, 2, "332121")],
    &[l(4, 0, 1, "3222"), l(4, 0, 2, "33221221"), l(4, 2, 1, "3221"), l(2, 0, 2, "3210"), l(2, 1, 2, "2330")],
    &[l(5, 0, 1, "32222"), l(5, 0, 2, "3322212221"), l(5, 2, 2, "2323230010"), l(5, 3, 1, "32221"), l(5, 3, 1, "30213"), l(10, 9, 1, "3112232211"),
      l(10, 9, 1, "1312123212"), l(10, 7, 1, "3221313120"), l(5, 4, 1, "31221"), l(5, 2, 2, "3302112213"), l(5, 1, 2, "2322330320"),
      l(10, 2, 1, "3223021131")],
    &[l(6, 0, 1, "322222"), l(6, 0, 2, "322223132220"), l(6, 0, 2, "322223213220"), l(6, 0, 2, "322223221320"), l(6, 1, 1, "303222"),
      l(6, 0, 2, "322232103200"), l(6, 0, 2, "232322300210"), l(6, 1, 1, "320322"), l(3, 0, 2, "232300"), l(3, 0, 2, "322100"),
      l(4, 0, 3, "332212101021"), l(6, 5, 1, "322121"), l(4, 0, 3, "322231311202"), l(3, 0, 4, "322213112023"), l(3, 1, 2, "320310"),
      l(6, 4, 1, "330210"), l(6, 5, 2, "302231313202"), l(6, 5, 2, "313220122231"), l(6, 5, 1, "312211"), l(6, 1, 1, "132203"), l(6, 1, 1, "113222"),
      l(4, 0, 3, "322213312012"), l(4, 0, 3, "130212213131"), l(6, 2, 2, "323201312212"), l(2, 0, 3, "322112"), l(2, 0, 3, "321021"),
      l(2, 0, 3, "320312"), l(6, 5, 1, "312212"), l(6, 2, 2, "321312212032"), l(6, 3, 2, "231221302132"), l(6, 3, 2, "320231132203"),
      l(6, 2, 1, "313202"), l(3, 0, 4, "322321130122"), l(12, 5, 1, "302231313220"), l(4, 2, 3, "132012211331")],
];

/// Pieces of 1 to 5 hexagons.
#[rustfmt::skip]
const HEXAGONS: [&[Layout]; 5] = [
    &[l(1, 0, 1, "7")],
    &[l(2, 0, 1, "73")],
    &[l(6, 4, 1, "755557"), l(6, 2, 1, "714367"), l(3, 0, 1, "727")],
    &[l(8, 6, 1, "75555557"), l(2, 0, 2, "6730"), l(4, 0, 1, "6727"), l(1, 0, 4, "7355"), l(2, 0, 4, "75766533"), l(2, 0, 4, "71674355"),
      l(2, 0, 2, "7356")],
    &[l(10, 8, 1, "7555555557"), l(1, 0, 5, "35557"), l(10, 8, 1, "7165555743"), l(10, 8, 1, "7165574355"), l(1, 0, 5, "35575"),
      l(10, 8, 1, "7143557143"), l(10, 8, 1, "6741437141"), l(10, 7, 1, "3156543377"), l(10, 4, 1, "2655776573"), l(2, 0, 5, "7372557372"),
      l(10, 4, 1, "7176434271"), l(5, 1, 1, "71742"), l(10, 2, 1, "6567567273"), l(5, 4, 1, "75665"), l(5, 4, 1, "75566"), l(10, 4, 1, "6654271577"),
      l(10, 6, 1, "3257757314"), l(10, 4, 1, "7255737556"), l(10, 2, 1, "5576557372"), l(10, 8, 1, "7166557643"), l(5, 4, 1, "75656"),
      l(10, 4, 1, "7655727355")],
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_have_all_their_cells() {
        for l in SQUARES.iter().chain(&TRIANGLES).chain(&HEXAGONS).flat_map(|l| l.iter()) {
            assert_eq!(l.digits.len() as i64, l.columns * l.rows, "{l:?}");
            assert!((0..l.columns).contains(&l.shift), "{l:?}");
        }
    }
}
