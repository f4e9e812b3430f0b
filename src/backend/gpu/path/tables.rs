//! Directional albedos for the shaders: of the CPU's tables (`kernel/bsdf/albedo.rs`) those rows that the scene's roughnesses ask for.
//! Twin: `shaders/path/albedo.wesl`.

use super::super::buffers::append;
use crate::kernel::bsdf::albedo::{TABLE_SIDE, dielectric_mix_row, glass_row, mirror_mean, mirror_row};
use crate::scene::input::Scalar;
use rayon::prelude::*;
use std::collections::{BTreeSet, HashMap};

/// Which table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Kind {
    Dielectric,
    Glass,
}

/// A row to compute: place of its table, which table it is and of which index (none: the mirrors'), which row.
type Job = (u32, Option<(Kind, f32)>, usize);

/// Tables that were asked for: their places, and which of their rows.
#[derive(Default)]
pub(super) struct AlbedoTables {
    places: HashMap<(Kind, u32), (u32, BTreeSet<usize>)>,
    mirror_rows: BTreeSet<usize>,
}

impl AlbedoTables {
    /// Rows between which a roughness lies; all of them for one that is not known.
    fn rows(roughness: Option<&Scalar>) -> std::ops::RangeInclusive<usize> {
        let steps = (TABLE_SIDE - 1) as f32;
        let Some(r) = roughness.and_then(Scalar::as_constant) else { return 0..=TABLE_SIDE - 1 };
        let low = ((r.clamp(0.0, 1.0) * steps) as usize).min(TABLE_SIDE - 2);
        low..=low + 1
    }

    /// The table of mirrors will be looked at for a roughness.
    pub fn mirror(&mut self, roughness: Option<&Scalar>) {
        self.mirror_rows.extend(Self::rows(roughness));
    }

    /// Place of `dielectric_mix` of an index.
    pub fn dielectric(&mut self, eta: f32, roughness: Option<&Scalar>, words: &mut Vec<u32>) -> u32 {
        self.place(Kind::Dielectric, eta, roughness, words)
    }

    /// Place of `glass` of an index.
    pub fn glass(&mut self, eta: f32, roughness: Option<&Scalar>, words: &mut Vec<u32>) -> u32 {
        self.place(Kind::Glass, eta, roughness, words)
    }

    fn place(&mut self, kind: Kind, eta: f32, roughness: Option<&Scalar>, words: &mut Vec<u32>) -> u32 {
        let rows = Self::rows(roughness);
        let entry = self.places.entry((kind, eta.to_bits()));
        let (at, wanted) = entry.or_insert_with(|| (append(words, [0; TABLE_SIDE * TABLE_SIDE]), BTreeSet::new()));
        wanted.extend(rows);
        *at
    }

    /// Computes what was asked for; gives the place of the table of mirrors and their means.
    pub fn fill(&self, words: &mut Vec<u32>) -> u32 {
        if self.places.is_empty() && self.mirror_rows.is_empty() {
            return 0;
        }
        let mirror_at = append(words, [0; TABLE_SIDE * TABLE_SIDE + TABLE_SIDE]);
        let means_at = mirror_at + (TABLE_SIDE * TABLE_SIDE) as u32;
        let mut jobs: Vec<Job> = self.mirror_rows.iter().map(|r| (mirror_at, None, *r)).collect();
        for ((kind, eta), (at, rows)) in &self.places {
            jobs.extend(rows.iter().map(|r| (*at, Some((*kind, f32::from_bits(*eta))), *r)));
        }
        let rows: Vec<&[f32; TABLE_SIDE]> = jobs
            .par_iter()
            .map(|(_, what, row)| match what {
                None => mirror_row(*row),
                Some((Kind::Dielectric, eta)) => dielectric_mix_row(*eta, *row),
                Some((Kind::Glass, eta)) => glass_row(*eta, *row),
            })
            .collect();
        for ((at, _, row), values) in jobs.iter().zip(rows) {
            let first = *at as usize + row * TABLE_SIDE;
            words[first..first + TABLE_SIDE].iter_mut().zip(values).for_each(|(w, v)| *w = v.to_bits());
        }
        for row in &self.mirror_rows {
            let mean = mirror_mean(*row as f32 / (TABLE_SIDE - 1) as f32);
            words[means_at as usize + row] = mean.to_bits();
        }
        mirror_at
    }
}
