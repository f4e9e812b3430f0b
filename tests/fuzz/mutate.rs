//! Changes to inputs: by token for text, by byte for the rest.

/// A small generator (xorshift64*): the search must be repeatable, no more.
pub struct Random(u64);

impl Random {
    /// By seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_F491_4F6C_DD1D)
    }

    /// 0..n, and 0 for n = 0.
    pub fn below(&mut self, n: usize) -> usize {
        if n == 0 { 0 } else { ((self.next() >> 16) % n as u64) as usize }
    }

    /// One of them.
    pub fn pick<'t, T: ?Sized>(&mut self, from: &[&'t T]) -> &'t T {
        from[self.below(from.len())]
    }
}

/// Numbers at the edges of types and of sense.
const NUMBERS: &[&str] = &[
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "3",
    "5",
    "255",
    "256",
    "65535",
    "65536",
    "1e-10",
    "1e-30",
    "1e-320",
    "1e7",
    "2147483647",
    "2147483648",
    "-2147483649",
    "4294967295",
    "4294967296",
    "1e18",
    "1e19",
    "1e38",
    "1e39",
    "1e150",
    "1e200",
    "1e308",
    "-1e308",
    "1e400",
    "(1/0)",
    "(-1/0)",
    "(0*(1/0))",
    "0.5",
    "0.9999999",
    "1.0000001",
    "100",
    "1000",
    "89.999",
    "90",
    "180",
    "360",
    "<0,0,0>",
    "<1,1,1>",
    "<1e308,-1e308,0>",
    "<0,0,(1/0)>",
    "<1,2>",
    "<1,2,3,4>",
    "<1,2,3,4,5>",
    "x",
    "y",
    "z",
    "t",
    "u",
    "\"\"",
    "\"text\"",
    "\"a.png\"",
];

const PIECES: &[&str] = &[
    "{",
    "}",
    "(",
    ")",
    "<",
    ">",
    "[",
    "]",
    ",",
    ";",
    "#",
    "#end",
    "#else",
    "#if (1)",
    "#while (1)",
    "#for (I,0,3)",
    "#macro M(A)",
    "#declare A =",
    "#local B =",
    "#undef A",
    "#break",
    "#switch (1)",
    "#case (1)",
    "#include \"a.inc\"",
    "A",
    "B",
    "M(",
    "A[0]",
    "array[3]",
    "+",
    "-",
    "*",
    "/",
    "=",
    "!",
    "&",
    "|",
    "?",
    ":",
    ".",
    "\"",
    "/*",
    "*/",
    "//",
    "sphere { 0, 1 }",
    "union {",
    "box { -1, 1 }",
    "pigment {",
    "texture {",
    "finish {",
    "normal {",
    "function {",
    "transform {",
    "rotate",
    "scale 0",
    "scale 1e-200",
    "translate",
    "matrix <1,0,0,0,0,0,0,0,0,0,0,0>",
    "inverse",
    "hollow",
    "clipped_by {",
    "bounded_by {",
];

/// Words, numbers, strings, signs and blanks of a text.
fn tokens(text: &[u8]) -> Vec<Vec<u8>> {
    let class = |c: u8| match c {
        b'a'..=b'z' | b'A'..=b'Z' | b'_' | b'0'..=b'9' | b'.' => 0u8,
        b' ' | b'\t' | b'\r' => 1,
        _ => 2,
    };
    let mut out: Vec<Vec<u8>> = Vec::new();
    for &c in text {
        match out.last_mut() {
            Some(t) if class(c) != 2 && t.last().is_some_and(|&l| class(l) == class(c)) => t.push(c),
            _ => out.push(vec![c]),
        }
    }
    out
}

/// A changed text: some tokens left out, doubled, moved, replaced, taken from `other`.
pub fn text(input: &[u8], other: &[u8], words: &[&str], r: &mut Random) -> Vec<u8> {
    let mut t = tokens(input);
    let far = tokens(other);
    for _ in 0..=r.below(6) {
        let (at, n) = (r.below(t.len() + 1), 1 + r.below(8));
        let end = (at + n).min(t.len());
        match r.below(12) {
            0 => drop(t.drain(at..end)),
            1 => {
                let copy = t[at..end].to_vec();
                let times = 1 + r.below(3);
                (0..times).for_each(|_| drop(t.splice(end..end, copy.clone())));
            }
            2 | 3 => t.insert(at, format!(" {} ", r.pick(PIECES)).into()),
            4 => t.insert(at, format!(" {} ", r.pick(words)).into()),
            5..=7 => {
                let places: Vec<usize> = (0..t.len()).filter(|&i| t[i][0].is_ascii_digit() || t[i][0] == b'.').collect();
                if !places.is_empty() {
                    let place = places[r.below(places.len())];
                    t[place] = r.pick(NUMBERS).into();
                }
            }
            8 => {
                let places: Vec<usize> = (0..t.len()).filter(|&i| t[i][0].is_ascii_lowercase()).collect();
                if !places.is_empty() {
                    let place = places[r.below(places.len())];
                    t[place] = r.pick(words).into();
                }
            }
            9 | 10 => {
                let from = r.below(far.len());
                let to = (from + 1 + r.below(40)).min(far.len());
                t.splice(at..if r.below(2) == 0 { at } else { end }, far[from..to].to_vec());
            }
            _ => {
                let mut flat = t.concat();
                bytes_in_place(&mut flat, r);
                t = tokens(&flat);
            }
        }
    }
    let mut out = t.concat();
    out.truncate(20_000);
    out
}

/// Changed bytes: bits, edge values, cuts, doublings, pieces of `other`.
pub fn bytes(input: &[u8], other: &[u8], r: &mut Random) -> Vec<u8> {
    let mut b = input.to_vec();
    for _ in 0..=r.below(5) {
        let at = r.below(b.len());
        match r.below(10) {
            0 => b.truncate(at),
            1 => {
                let end = (at + 1 + r.below(32)).min(b.len());
                let copy = b[at..end].to_vec();
                b.splice(end..end, copy);
            }
            2 => {
                let from = r.below(other.len());
                let to = (from + 1 + r.below(64)).min(other.len());
                b.splice(at..at, other[from..to].iter().copied());
            }
            3 => drop(b.drain(at..(at + 1 + r.below(16)).min(b.len()))),
            _ => bytes_in_place(&mut b, r),
        }
    }
    b.truncate(100_000);
    b
}

fn bytes_in_place(b: &mut [u8], r: &mut Random) {
    if b.is_empty() {
        return;
    }
    let at = r.below(b.len());
    let edge = [0u32, 1, 0x7f, 0x80, 0xff, 0x100, 0x7fff, 0x8000, 0xffff, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 0x7f80_0000, 0x7fc0_0000]
        [r.below(14)];
    let n = [1, 2, 4][r.below(3)].min(b.len() - at);
    match r.below(4) {
        0 => b[at] ^= 1 << r.below(8),
        1 => b[at] = r.below(256) as u8,
        2 => b[at..at + n].copy_from_slice(&edge.to_le_bytes()[..n]),
        _ => b[at..at + n].copy_from_slice(&edge.to_be_bytes()[4 - n..]),
    }
}

/// The shortest input found by leaving parts out that still `harms`, within a number of tries.
pub fn minimise(input: &[u8], tries: usize, mut harms: impl FnMut(&[u8]) -> bool) -> Vec<u8> {
    let (mut best, mut left) = (input.to_vec(), tries);
    let mut size = best.len() / 2;
    while size > 0 && left > 0 {
        let mut at = 0;
        while at < best.len() && left > 0 {
            let mut shorter = best.clone();
            shorter.drain(at..(at + size).min(best.len()));
            left -= 1;
            if harms(&shorter) { best = shorter } else { at += size }
        }
        size /= 2;
    }
    best
}
