//! Patterns and their warps into words. The numbers behind each record are in the order that its function in `shaders/shared/` names.

use super::buffers::{low_part, real};
use super::texture_encoder::{Placed, TextureEncoder, bits};
use super::texture_layout::{PATTERN, PATTERN_KINDS, WARP_KINDS, WARP_LEN, WAVE_KINDS, kind};
use crate::backend::BackendError;
use crate::compile::NONE;
use crate::compile::texture::{PatternCode, PatternIx, PatternNode, Pavement, WarpNode, pattern_name};
use crate::kernel::pattern::penrose::{Rule, penrose_plan};
use crate::kernel::pattern::tiling::tiling_plan;
use crate::math::DVec3;
use crate::scene::pattern::Wave;

/// Patterns that may be sums of scalar noise.
const SCALAR_NOISE: [&str; 9] = ["agate", "bozo", "bumps", "dents", "granite", "marble", "spiral1", "spiral2", "wrinkles"];

fn three(v: DVec3) -> [u32; 3] {
    v.to_array().map(bits)
}

fn reals(v: DVec3) -> Vec<u32> {
    v.to_array().into_iter().flat_map(real).collect()
}

impl TextureEncoder<'_> {
    /// The record of a pattern; its stack is what the pigment that gives its value takes, else 0.
    pub fn pattern(&mut self, ix: PatternIx) -> Result<Placed, BackendError> {
        if let Some(known) = self.known_patterns.get(&ix) {
            return Ok(*known);
        }
        let node = self.tables.patterns[ix as usize];
        let name = pattern_name(&node.code);
        if !PATTERN_KINDS.contains(&name) {
            return Err(BackendError::Unsupported(format!("the pattern '{name}'")));
        }
        self.feature(format!("pattern_{name}"));
        if SCALAR_NOISE.contains(&name) {
            self.feature("scalar_noise");
        }
        let (arguments, stack) = self.arguments(&node.code)?;
        let mut warps = Vec::new();
        for w in node.warps.of(&self.tables.warps) {
            let (name, mut words) = warp_words(w);
            self.feature(format!("warp_{name}"));
            words.insert(0, kind(WARP_KINDS, name));
            assert!(words.len() <= WARP_LEN as usize, "warps fit their records");
            words.resize(WARP_LEN as usize, 0);
            warps.extend(words);
        }
        let transform_at = match node.transform_ix {
            NONE => 0,
            ix => {
                let t = &self.tables.transforms[ix as usize];
                self.put_matrices(t.forward.matrix3.transpose(), t.inverse.matrix3.transpose())
            }
        };
        let warps_at = self.put(warps);
        if node.wave != Wave::Ramp {
            self.feature("shaped_waves");
        }
        if node.noise_generator >= 3 {
            self.feature("noise_generator_3");
        }
        let at = self.put(record_words(&node, name, warps_at, transform_at));
        self.put(arguments);
        let placed = Placed { at, stack };
        self.known_patterns.insert(ix, placed);
        Ok(placed)
    }

    /// The numbers behind a pattern's record, and the stack that its pigment takes.
    fn arguments(&mut self, code: &PatternCode) -> Result<(Vec<u32>, u32), BackendError> {
        let words = match *code {
            PatternCode::Agate { turb } => vec![bits(turb)],
            PatternCode::Brick { size, mortar } => [reals(size), real(mortar).to_vec()].concat(),
            PatternCode::Crackle { form, metric, offset, solid } => {
                let needed = if solid { 1 } else { (0..3).rev().find(|k| form[*k] != 0.0).map_or(1, |k| k as u32 + 1) };
                [&three(form)[..], &[bits(metric), bits(offset), u32::from(solid), needed]].concat()
            }
            PatternCode::Density { grid, interpolate } => {
                let grid = self.tables.grids[grid as usize].clone();
                if grid.size.contains(&0) {
                    return Err(BackendError::Unsupported("an empty density file".to_owned()));
                }
                self.feature("image_words");
                let at = self.images.put(grid.values.iter().map(|v| v.to_bits()));
                // The cell before the first, as the kernel has it.
                let before = grid.size.map(|n| (u64::MAX % u64::from(n)) as u32);
                [&grid.size[..], &[u32::from(interpolate), at], &before[..]].concat()
            }
            PatternCode::Facets { coords, size, metric } => {
                vec![u32::from(coords.is_some()), bits(coords.unwrap_or(0.0)), bits(size), bits(metric)]
            }
            PatternCode::Fractal(ix) => {
                let f = &self.tables.fractals[ix as usize];
                let (a, b) = f.julia.unwrap_or_default();
                let head = [u32::from(f.magnet), u32::from(f.julia.is_some())];
                let own = [&head[..], &real(a), &real(b), &[f.iterations, f.exponent]].concat();
                let parts = [f.exterior, f.interior].map(|(kind, factor)| [u32::from(kind), bits(factor)]);
                [&own[..], &parts[0], &parts[1]].concat()
            }
            PatternCode::Function(ix) => vec![self.function(ix)],
            PatternCode::Gradient(direction) => reals(direction),
            PatternCode::Image(ix) => vec![self.image(ix)],
            PatternCode::Object(slot) => self.insides.get(slot as usize).copied().unwrap_or_default().to_vec(),
            PatternCode::Pavement(ref p) => pavement_words(p),
            PatternCode::Pigment(ix) => {
                // Wherever its value is asked for, the loop that gathers colours answers.
                self.feature("nested_pigments");
                let placed = self.placed_pigment(ix)?;
                self.room_for_pattern(placed);
                return Ok((vec![placed.at], placed.stack));
            }
            PatternCode::Quilted { control0, control1 } => vec![bits(control0), bits(control1)],
            PatternCode::Ripples | PatternCode::Waves => {
                let sources = &self.tables.wave_sources;
                if self.wave_sources_at == 0 {
                    self.wave_sources_at =
                        self.put(sources.iter().flat_map(|(place, f)| [place.x, place.y, place.z, *f].into_iter().flat_map(real)));
                }
                vec![sources.len() as u32, self.wave_sources_at]
            }
            PatternCode::Slope(ix) => {
                let s = self.tables.slopes[ix as usize];
                let (axis, low, high, share) = s.altitude.unwrap_or_default();
                let own = [u32::from(s.point_at), bits(s.low), bits(s.high), u32::from(s.altitude.is_some())];
                [&three(s.direction)[..], &own, &three(axis), &[bits(low), bits(high), bits(share)]].concat()
            }
            PatternCode::Spiral1 { arms } | PatternCode::Spiral2 { arms } => vec![bits(arms)],
            PatternCode::Tiling(n) => penrose_words(n).unwrap_or_else(|| tiling_words(n)),
            _ => Vec::new(),
        };
        Ok((words, 0))
    }
}

fn record_words(node: &PatternNode, name: &str, warps_at: u32, transform_at: u32) -> Vec<u32> {
    let (wave, exponent) = match node.wave {
        Wave::Ramp => ("ramp", 0.0),
        Wave::Triangle => ("triangle", 0.0),
        Wave::Sine => ("sine", 0.0),
        Wave::Scallop => ("scallop", 0.0),
        Wave::Cubic => ("cubic", 0.0),
        Wave::Poly(e) => ("poly", e),
    };
    let [x, y, z] = three(node.turb_amount);
    PATTERN.words(&[
        ("KIND", kind(PATTERN_KINDS, name)),
        ("WARPS_AT", warps_at),
        ("N_WARPS", node.warps.len),
        ("FREQUENCY", bits(node.frequency)),
        ("PHASE", bits(node.phase)),
        ("WAVE", kind(WAVE_KINDS, wave)),
        ("EXPONENT", exponent.to_bits()),
        ("GENERATOR", u32::from(node.noise_generator.clamp(1, 3))),
        ("TURB_AMOUNT", x),
        ("TURB_AMOUNT_Y", y),
        ("TURB_AMOUNT_Z", z),
        ("OCTAVES", node.turb.octaves),
        ("OMEGA", node.turb.omega.to_bits()),
        ("LAMBDA", node.turb.lambda.to_bits()),
        ("TRANSFORM_AT", transform_at),
    ])
}

fn warp_words(w: &WarpNode) -> (&'static str, Vec<u32>) {
    match *w {
        WarpNode::Affine(m) => {
            let columns = m.to_cols_array();
            ("affine", [columns.map(bits), columns.map(|v| low_part(v).to_bits())].concat())
        }
        WarpNode::Turbulence { amount, noise } => {
            ("turbulence", [&three(amount)[..], &[noise.octaves, noise.omega.to_bits(), noise.lambda.to_bits()]].concat())
        }
        WarpNode::Repeat { axis, width, offset, flip } => {
            let flips = flip.iter().enumerate().map(|(k, f)| u32::from(*f) << k).sum();
            ("repeat", [&[u32::from(axis), bits(width)], &three(offset)[..], &[flips]].concat())
        }
        WarpNode::BlackHole { center, radius, strength, inverse, falloff, repeat, repeats, turbulence } => {
            let own = [bits(radius), bits(strength), u32::from(inverse), bits(falloff), u32::from(repeats)];
            ("black_hole", [&three(center)[..], &own, &three(repeat), &three(turbulence)].concat())
        }
        WarpNode::Cylindrical { orientation, dist_exp } => ("cylindrical", [&three(orientation)[..], &[bits(dist_exp)]].concat()),
        WarpNode::Spherical { orientation, dist_exp } => ("spherical", [&three(orientation)[..], &[bits(dist_exp)]].concat()),
        WarpNode::Toroidal { orientation, dist_exp, major_radius } => {
            ("toroidal", [&three(orientation)[..], &[bits(dist_exp), bits(major_radius)]].concat())
        }
        WarpNode::Planar { orientation, distance } => ("planar", [&three(orientation)[..], &[bits(distance)]].concat()),
        WarpNode::Cubic => ("cubic", Vec::new()),
    }
}

fn pavement_words(p: &Pavement) -> Vec<u32> {
    let l = &p.layout;
    let mut words = vec![u32::from(p.sides), u32::from(p.interior), u32::from(p.exterior), u32::from(p.form)];
    words.extend([l.columns, l.shift, l.rows].map(|v| v as u32));
    // Eight digits a word.
    words.extend(l.digits.as_bytes().chunks(8).map(|d| d.iter().rev().fold(0, |w, d| w << 4 | u32::from(d - b'0'))));
    words
}

fn penrose_words(n: u8) -> Option<Vec<u32>> {
    let t = penrose_plan(n)?;
    let mut words = vec![bits(t.kinds), u32::from(t.rule == Rule::Kites), bits(t.side)];
    words.push(u32::from(t.start.0));
    words.extend(t.start.1.into_iter().flatten().map(bits));
    let lists = t.tiles.each_ref().map(|tiles| {
        let mut list = vec![tiles.len() as u32];
        for (kind, sides) in tiles {
            list.extend([bits(*kind), sides.len() as u32]);
            list.extend(sides.iter().flat_map(|s| [s.line, s.guards[0], s.guards[1]]).flatten().map(bits));
        }
        list
    });
    let first = words.len() + 2;
    words.extend([first as u32, (first + lists[0].len()) as u32]);
    words.extend(lists.concat());
    Some(words)
}

fn tiling_words(n: u8) -> Vec<u32> {
    let t = tiling_plan(n).expect("a tiling by lattice");
    let [u, v] = t.lattice;
    // Enough for a single float to lie above the part's start.
    let least = if t.floor > 0.0 { t.floor.max(3e-7) } else { 0.0 };
    let mut words = vec![bits(t.kinds), bits(u[0]), bits(u[1]), bits(v[0]), bits(v[1]), bits(least), t.tiles.len() as u32];
    for (kind, sides) in &t.tiles {
        words.extend([bits(*kind), sides.len() as u32]);
        words.extend(sides.iter().flatten().map(|v| bits(*v)));
    }
    words
}
