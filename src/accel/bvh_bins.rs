//! What the BVH's build counts: boxes in registers of four, references in bins, parting a list without guesses.

use super::{BoxF, PrimRef};
use glam::Vec4;
use rayon::prelude::*;

/// Bins of an axis in large nodes.
pub(super) const N_BINS: usize = 32;
/// Nodes with more references are also binned in parallel, in pieces of this size.
pub(super) const CHUNK: usize = 1 << 16;

/// A box in registers of four; the fourth number means nothing.
#[derive(Clone, Copy)]
pub(super) struct Box4 {
    pub(super) lo: Vec4,
    pub(super) hi: Vec4,
}

impl Box4 {
    pub(super) const EMPTY: Self = Self { lo: Vec4::INFINITY, hi: Vec4::NEG_INFINITY };

    #[inline(always)]
    pub(super) fn grow(&mut self, other: &Self) {
        self.lo = self.lo.min(other.lo);
        self.hi = self.hi.max(other.hi);
    }

    /// Whether it is [`Self::EMPTY`].
    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.lo.x > self.hi.x
    }

    #[inline(always)]
    pub(super) fn to_boxf(self) -> BoxF {
        BoxF { lo: self.lo.truncate().to_array(), hi: self.hi.truncate().to_array() }
    }
}

/// A primitive's box. Its number stands in the two fourth places, as the fractions of numbers between 1 and 2: sums of them stay ordinary.
#[derive(Clone, Copy)]
pub(super) struct Ref(Box4);

const FRACTION_BITS: u32 = f32::MANTISSA_DIGITS - 1;
const ONE: u32 = 1.0f32.to_bits();

impl Ref {
    pub(super) fn new(r: &PrimRef) -> Self {
        let [low, high] = [r.prim & ((1 << FRACTION_BITS) - 1), r.prim >> FRACTION_BITS].map(|part| f32::from_bits(ONE | part));
        let ([x, y, z], [u, v, w]) = (r.bounds.lo, r.bounds.hi);
        Self(Box4 { lo: Vec4::new(x, y, z, low), hi: Vec4::new(u, v, w, high) })
    }

    pub(super) fn prim(&self) -> u32 {
        (self.0.lo.w.to_bits() ^ ONE) | (self.0.hi.w.to_bits() ^ ONE) << FRACTION_BITS
    }

    /// Its box.
    #[inline(always)]
    pub(super) fn bounds(&self) -> &Box4 {
        &self.0
    }

    /// Twice the centroid.
    #[inline(always)]
    pub(super) fn center(&self) -> Vec4 {
        self.0.lo + self.0.hi
    }
}

/// Twice the centroid.
#[inline]
pub(super) fn center(r: &Ref, axis: usize) -> f32 {
    r.center()[axis]
}

/// Box of the doubled centroids.
pub(super) fn centers_of(refs: &[Ref]) -> BoxF {
    folded(refs, |r| Box4 { lo: r.center(), hi: r.center() }).to_boxf()
}

/// The box of them all.
pub(super) fn box_of(refs: &[Ref]) -> Box4 {
    folded(refs, |r| r.0)
}

fn folded(refs: &[Ref], of: impl Fn(&Ref) -> Box4 + Sync) -> Box4 {
    let grown = |mut a: Box4, b: Box4| {
        a.grow(&b);
        a
    };
    let all = |refs: &[Ref]| refs.iter().fold(Box4::EMPTY, |b, r| grown(b, of(r)));
    if refs.len() > CHUNK { refs.par_chunks(CHUNK).map(all).reduce(|| Box4::EMPTY, grown) } else { all(refs) }
}

/// Moves what belongs to the left to the front, and counts it. Every reference is moved: which belongs where cannot be foretold, and a wrong guess
/// of the processor costs more.
pub(super) fn partition(refs: &mut [Ref], is_left: impl Fn(&Ref) -> bool) -> usize {
    let mut n_left = 0;
    for i in 0..refs.len() {
        let goes_left = is_left(&refs[i]);
        refs.swap(i, n_left);
        n_left += usize::from(goes_left);
    }
    n_left
}

/// Which bin a centroid falls into.
pub(super) struct BinMap {
    lo: Vec4,
    scale: Vec4,
    pub(super) n_bins: usize,
}

impl BinMap {
    /// `None` when all centroids are in one place.
    pub(super) fn new(centers: &BoxF, n_bins: usize) -> Option<Self> {
        let scale: [f32; 3] = std::array::from_fn(|k| {
            // Just below, so that the last centroid falls into the last bin.
            let s = n_bins as f32 * 0.999_99 / (centers.hi[k] - centers.lo[k]);
            if s.is_finite() { s } else { 0.0 }
        });
        let of = |v: [f32; 3]| Vec4::new(v[0], v[1], v[2], 0.0);
        scale.iter().any(|s| *s > 0.0).then_some(Self { lo: of(centers.lo), scale: of(scale), n_bins })
    }

    /// By axis.
    #[inline(always)]
    pub(super) fn bins(&self, r: &Ref) -> [i32; 4] {
        let place = (r.center() - self.lo) * self.scale;
        place.to_array().map(|v| v as i32)
    }
}

/// Boxes and numbers of the references in each bin.
pub(super) struct Bins {
    pub(super) boxes: [[Box4; N_BINS]; 3],
    pub(super) counts: [[u32; N_BINS]; 3],
}

impl Bins {
    pub(super) fn empty() -> Self {
        Self { boxes: [[Box4::EMPTY; N_BINS]; 3], counts: [[0; N_BINS]; 3] }
    }

    /// Of these references alone; bins that the map does not use stay as they were.
    pub(super) fn count(&mut self, map: &BinMap, refs: &[Ref]) {
        for axis in 0..3 {
            self.boxes[axis][..map.n_bins].fill(Box4::EMPTY);
            self.counts[axis][..map.n_bins].fill(0);
        }
        for r in refs {
            let at = map.bins(r);
            for axis in 0..3 {
                let i = (at[axis] as usize).min(N_BINS - 1);
                self.boxes[axis][i].grow(&r.0);
                self.counts[axis][i] += 1;
            }
        }
    }

    pub(super) fn merged(mut self: Box<Self>, other: Box<Self>) -> Box<Self> {
        for axis in 0..3 {
            for i in 0..N_BINS {
                self.boxes[axis][i].grow(&other.boxes[axis][i]);
                self.counts[axis][i] += other.counts[axis][i];
            }
        }
        self
    }
}

/// Room that nodes use one after the other.
pub(super) struct Scratch {
    pub(super) bins: Box<Bins>,
    /// By bin: the box of all from it on, and what they cost.
    pub(super) above: Box<[(Box4, f64); N_BINS]>,
}

impl Scratch {
    pub(super) fn new() -> Self {
        Self { bins: Box::new(Bins::empty()), above: Box::new([(Box4::EMPTY, f64::INFINITY); N_BINS]) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reference(prim: u32, at: f32) -> Ref {
        Ref::new(&PrimRef { bounds: BoxF { lo: [at; 3], hi: [at + 1.0; 3] }, prim })
    }

    #[test]
    fn references_keep_their_numbers() {
        for prim in [0, 1, (1 << 23) - 1, 1 << 23, 12_345_678, (1 << 30) - 1] {
            let r = reference(prim, 2.0);
            assert_eq!(r.prim(), prim);
            assert_eq!(r.center().truncate().to_array(), [5.0; 3]);
            assert!(r.center().w.is_normal());
        }
    }

    #[test]
    fn parting_loses_nothing() {
        let mut refs: Vec<Ref> = (0..100).map(|k| reference(k, (k * 37 % 100) as f32)).collect();
        let n_left = partition(&mut refs, |r| r.center().x < 61.0);
        assert_eq!(n_left, 30);
        assert!(refs[..n_left].iter().all(|r| r.center().x < 61.0) && refs[n_left..].iter().all(|r| r.center().x >= 61.0));
        let mut all: Vec<u32> = refs.iter().map(Ref::prim).collect();
        all.sort_unstable();
        assert!(all.iter().enumerate().all(|(k, prim)| k == *prim as usize));
    }
}
