//! The tables behind noise, crackle and cells, as the first words of every texture buffer.

use crate::math::noise::{NOISE_TABLE, perlin_tables};
use crate::math::random::{HASH, HASH_LEN, uniform_table};

/// The tables and where they stand.
pub(super) struct NoiseTables {
    pub words: Vec<u32>,
    /// Their places by name.
    pub places: Vec<(&'static str, u32)>,
}

impl Default for NoiseTables {
    fn default() -> Self {
        // Word 0 is no record.
        let mut tables = NoiseTables { words: vec![0], places: Vec::new() };
        tables.add("LATTICE_AT", NOISE_TABLE.iter().map(|v| (*v as f32).to_bits()));
        tables.add("HASH_AT", HASH[..HASH_LEN / 2].iter().map(|v| u32::from(*v)));
        // Looked up by hash, three in a row.
        tables.add("UNIFORM_AT", uniform_table()[..HASH_LEN / 2 + 3].iter().map(|v| (*v as f32).to_bits()));
        let (gradients, permutation) = perlin_tables();
        tables.add("PERLIN_PERMUTATION_AT", permutation[..gradients.len()].iter().map(|v| *v as u32));
        tables.add("PERLIN_GRADIENTS_AT", gradients.iter().flat_map(|v| v.to_array().map(|v| (v as f32).to_bits())));
        tables
    }
}

impl NoiseTables {
    fn add(&mut self, name: &'static str, list: impl Iterator<Item = u32>) {
        self.places.push((name, self.words.len() as u32));
        self.words.extend(list);
    }
}
