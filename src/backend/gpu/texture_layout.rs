//! How texture records are laid out in words, written once for both sides: the encoder asks for places by name, and the shaders get
//! the same places as constants (module `constants`).

/// A kind of record: its words by name.
pub(super) struct Record {
    name: &'static str,
    fields: &'static [&'static str],
}

impl Record {
    /// Words in front of what each kind adds.
    pub fn len(&self) -> u32 {
        self.fields.len() as u32
    }

    /// The words of a record; fields that are not given are 0.
    pub fn words(&self, values: &[(&str, u32)]) -> Vec<u32> {
        let mut words = vec![0; self.fields.len()];
        for (name, value) in values {
            let place = self.fields.iter().position(|f| f == name).expect("fields are named as in the layout");
            words[place] = *value;
        }
        words
    }
}

pub(super) const PATTERN: Record = Record {
    name: "PATTERN",
    fields: &[
        "KIND",
        "WARPS_AT",
        "N_WARPS",
        "FREQUENCY",
        "PHASE",
        "WAVE",
        "EXPONENT",
        "GENERATOR",
        "TURB_AMOUNT",
        "TURB_AMOUNT_Y",
        "TURB_AMOUNT_Z",
        "OCTAVES",
        "OMEGA",
        "LAMBDA",
        "TRANSFORM_AT",
    ],
};
pub(super) const PIGMENT: Record = Record { name: "PIGMENT", fields: &["KIND", "PATTERN_AT", "ENTRIES_AT", "N_ENTRIES", "UV", "WEIGHT"] };
pub(super) const NORMAL: Record = Record {
    name: "NORMAL",
    fields: &["KIND", "PATTERN_AT", "ENTRIES_AT", "N_ENTRIES", "UV", "WEIGHT", "AMOUNT", "ACCURACY", "NO_BUMP_SCALE"],
};
pub(super) const TEXTURE: Record =
    Record { name: "TEXTURE", fields: &["KIND", "PATTERN_AT", "ENTRIES_AT", "N_ENTRIES", "UV", "WEIGHT", "IMAGE_AT", "TRANSFORM_AT"] };
pub(super) const IMAGE: Record = Record {
    name: "IMAGE",
    fields: &[
        "WIDTH",
        "HEIGHT",
        "MAP_TYPE",
        "INTERPOLATION",
        "ONCE",
        "REPEAT_U",
        "REPEAT_V",
        "OFFSET_U",
        "OFFSET_V",
        "USE_INDEX",
        "ALPHA_USE",
        "FILTER_ALL",
        "TRANSMIT_ALL",
        "PREMULTIPLIED",
        "FORMAT",
        "PIXELS_AT",
        "PALETTE_AT",
    ],
};

/// Words of a warp: its kind and the most numbers that one takes.
pub(super) const WARP_LEN: u32 = 25;

/// Names of kinds; the number of a kind is its place.
pub(super) const PATTERN_KINDS: &[&str] = &[
    "plain",
    "agate",
    "aoi",
    "boxed",
    "bozo",
    "brick",
    "bumps",
    "cells",
    "checker",
    "crackle",
    "cubic",
    "cylindrical",
    "density_file",
    "dents",
    "facets",
    "function",
    "mandel",
    "gradient",
    "granite",
    "hexagon",
    "image_pattern",
    "leopard",
    "marble",
    "object",
    "onion",
    "pavement",
    "penrose",
    "pigment_pattern",
    "planar",
    "quilted",
    "radial",
    "ripples",
    "slope",
    "spherical",
    "spiral1",
    "spiral2",
    "square",
    "tiling",
    "triangular",
    "waves",
    "wood",
    "wrinkles",
];
pub(super) const WARP_KINDS: &[&str] =
    &["affine", "turbulence", "repeat", "black_hole", "cylindrical", "spherical", "toroidal", "planar", "cubic"];
pub(super) const WAVE_KINDS: &[&str] = &["ramp", "triangle", "sine", "scallop", "cubic", "poly"];
pub(super) const PIGMENT_KINDS: &[&str] = &["solid", "colors", "map", "average", "image"];
pub(super) const NORMAL_KINDS: &[&str] = &["own", "slope", "map", "average", "bump"];
pub(super) const TEXTURE_KINDS: &[&str] = &["layers", "map", "average", "material_map", "principled"];
pub(super) const IMAGE_FORMATS: &[&str] = &["indexed", "gray16", "bytes", "floats"];
pub(super) const MAP_TYPES: &[&str] = &["planar", "spherical", "cylindrical", "torus"];
pub(super) const INTERPOLATIONS: &[&str] = &["none", "bilinear", "bicubic", "normalized"];
pub(super) const ALPHA_USES: &[&str] = &["none", "transmit", "red"];

/// The number of a kind.
pub(super) fn kind(list: &[&str], name: &str) -> u32 {
    list.iter().position(|n| *n == name).expect("kinds are named as in the layout") as u32
}

/// The constants of the layout by name.
pub(super) fn layout_constants() -> Vec<(String, u32)> {
    let mut list = Vec::new();
    let mut add = |name: &str, value: u32| list.push((name.to_owned(), value));
    for record in [&PATTERN, &PIGMENT, &NORMAL, &TEXTURE, &IMAGE] {
        for (place, field) in record.fields.iter().enumerate() {
            add(&format!("{}_{field}", record.name), place as u32);
        }
        add(&format!("{}_LEN", record.name), record.len());
    }
    add("WARP_LEN", WARP_LEN);
    let lists = [
        ("PATTERN", PATTERN_KINDS),
        ("WARP", WARP_KINDS),
        ("WAVE", WAVE_KINDS),
        ("PIGMENT", PIGMENT_KINDS),
        ("NORMAL", NORMAL_KINDS),
        ("TEXTURE", TEXTURE_KINDS),
        ("IMAGE", IMAGE_FORMATS),
        ("MAP", MAP_TYPES),
        ("INTERPOLATION", INTERPOLATIONS),
        ("ALPHA", ALPHA_USES),
    ];
    for (prefix, list) in lists {
        for (value, name) in list.iter().enumerate() {
            add(&format!("{prefix}_{}", name.to_uppercase()), value as u32);
        }
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_constant_is_declared_twice() {
        let mut names: Vec<String> = layout_constants().into_iter().map(|(name, _)| name).collect();
        names.sort_unstable();
        let all = names.len();
        names.dedup();
        assert_eq!(names.len(), all);
    }
}
