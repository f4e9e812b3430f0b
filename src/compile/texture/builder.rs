//! Fills [`TextureTables`] from the scene's textures. Parts shared by `Arc` are entered once.

use super::default_maps::default_map;
use super::*;
use crate::compile::NONE;
use crate::compile::function::{FunctionKey, FunctionNode, compile_expr};
use crate::compile::spline::second_derivatives;
use crate::math::noise::noise_vector;
use crate::math::random::lcg_step;
use crate::scene::image::Pixels;
use crate::scene::pattern::Turbulence;
use crate::scene::{
    BlendMap, Finish, Function, FunctionBody, Normal, NormalKind, Object, Pattern, PatternKind, Pigment, PigmentKind, Settings, Spline,
    Texture, Warp,
};
use std::any::Any;
use std::collections::HashMap;

/// What is known of a part besides its entry.
#[derive(Clone, Copy, Default)]
struct Traits {
    /// Light may get through somewhere.
    transparent: bool,
    /// It looks at (u, v).
    uv: bool,
}

impl Traits {
    fn or(self, o: Traits) -> Traits {
        Traits { transparent: self.transparent || o.transparent, uv: self.uv || o.uv }
    }
}

/// Collects textures.
pub struct TextureBuilder {
    tables: TextureTables,
    number_of_waves: u32,
    /// Indices by the address of the shared part.
    known: HashMap<(*const (), u8), u32>,
    /// User functions by what they do.
    compiled: HashMap<FunctionKey, FunctionIx>,
    /// Keeps addresses taken.
    keep: Vec<Arc<dyn Any>>,
    texture_traits: Vec<Traits>,
    pigment_traits: Vec<Traits>,
    normal_uv: Vec<bool>,
    /// Some pigment pattern looks at (u, v); which covers use it is not followed up.
    uv_in_pattern: bool,
    objects: Vec<Arc<Object>>,
}

/// Tables of [`TextureBuilder::known`].
mod table {
    pub const TEXTURE: u8 = 0;
    pub const PIGMENT: u8 = 1;
    pub const NORMAL: u8 = 2;
    pub const FINISH: u8 = 3;
    pub const IMAGE: u8 = 4;
    pub const GRID: u8 = 5;
    pub const COLORS: u8 = 6;
    pub const PIGMENTS: u8 = 7;
    pub const NORMALS: u8 = 8;
    pub const SLOPES: u8 = 9;
    pub const FUNCTION: u8 = 10;
    pub const NORMALS_UNSCALED: u8 = 11;
}

impl Default for TextureBuilder {
    fn default() -> Self {
        Self::new(&Settings::default())
    }
}

impl TextureBuilder {
    /// Nothing yet, for a scene with these settings.
    pub fn new(settings: &Settings) -> Self {
        Self {
            tables: TextureTables { noise_generator: settings.noise_generator, ..TextureTables::default() },
            number_of_waves: settings.number_of_waves,
            known: HashMap::new(),
            compiled: HashMap::new(),
            keep: Vec::new(),
            texture_traits: Vec::new(),
            pigment_traits: Vec::new(),
            normal_uv: Vec::new(),
            uv_in_pattern: false,
            objects: Vec::new(),
        }
    }

    fn known<T>(&self, part: &Arc<T>, table: u8) -> Option<u32> {
        self.known.get(&(Arc::as_ptr(part).cast(), table)).copied()
    }

    fn learn<T: 'static>(&mut self, part: &Arc<T>, table: u8, ix: u32) -> u32 {
        self.known.insert((Arc::as_ptr(part).cast(), table), ix);
        self.keep.push(part.clone());
        ix
    }

    /// The index of a texture.
    pub fn texture(&mut self, t: &Arc<Texture>) -> TextureIx {
        if let Some(ix) = self.known(t, table::TEXTURE) {
            return ix;
        }
        let (node, traits) = self.texture_node(t);
        self.tables.textures.push(node);
        self.texture_traits.push(traits);
        self.learn(t, table::TEXTURE, self.tables.textures.len() as u32 - 1)
    }

    fn texture_node(&mut self, t: &Texture) -> (TextureNode, Traits) {
        match t {
            Texture::Layers(list) => {
                let mut traits = Traits { transparent: true, uv: false };
                let mut layers = Vec::with_capacity(list.len());
                for l in list {
                    let pigment = self.pigment(&l.pigment);
                    let normal = l.normal.as_ref().map_or(NONE, |n| self.normal(n));
                    let finish = self.finish_entry(&l.finish);
                    let own = self.pigment_traits[pigment as usize];
                    traits.transparent &= own.transparent;
                    traits.uv |= own.uv || self.normal_uv.get(normal as usize).is_some_and(|uv| *uv);
                    layers.push(Layer { pigment, normal, finish });
                }
                let start = self.tables.layers.len() as u32;
                self.tables.layers.extend(layers);
                (TextureNode::Layers { start, len: list.len() as u32 }, traits)
            }
            Texture::Map { pattern, map, uv_mapping } | Texture::Average { pattern, map, uv_mapping } => {
                let (range, mut traits) = self.texture_entries(map.entries.iter().map(|(at, t)| (*at, t)));
                traits.uv |= *uv_mapping;
                let (Range { start, len }, uv_mapping) = (range, *uv_mapping);
                let average = matches!(t, Texture::Average { .. });
                let pattern = self.pattern(pattern);
                let node = if average {
                    TextureNode::Average { pattern, start, len, uv_mapping }
                } else {
                    TextureNode::Map { pattern, start, len, uv_mapping }
                };
                (node, traits)
            }
            Texture::MaterialMap { pattern, image, textures } => {
                let (Range { start, len }, traits) = self.texture_entries(textures.iter().map(|t| (1.0, t)));
                let (pattern, image) = (self.pattern(pattern), self.image(image));
                (TextureNode::MaterialMap { pattern, image, start, len }, traits)
            }
            Texture::Principled(p) => {
                let transparent = p.lets_light_through();
                self.tables.principled.push((**p).clone());
                (TextureNode::Principled(self.tables.principled.len() as u32 - 1), Traits { transparent, uv: true })
            }
        }
    }

    fn texture_entries<'t>(&mut self, list: impl Iterator<Item = (f32, &'t Arc<Texture>)>) -> (Range, Traits) {
        let entries: Vec<(f32, u32)> = list.map(|(at, t)| (at, self.texture(t))).collect();
        let traits = entries.iter().fold(Traits::default(), |sum, (_, t)| sum.or(self.texture_traits[*t as usize]));
        (append(&mut self.tables.texture_entries, entries), traits)
    }

    fn finish_entry(&mut self, f: &Arc<Finish>) -> FinishIx {
        if let Some(ix) = self.known(f, table::FINISH) {
            return ix;
        }
        self.tables.finishes.push((**f).clone());
        self.learn(f, table::FINISH, self.tables.finishes.len() as u32 - 1)
    }

    /// Whether light may get through a texture somewhere. Source: spec/light.md, section 6 ("opaque object").
    pub fn is_transparent(&self, t: TextureIx) -> bool {
        self.texture_traits[t as usize].transparent
    }

    /// Whether a texture looks at (u, v) itself.
    pub fn needs_uv(&self, t: TextureIx) -> bool {
        self.uv_in_pattern || self.texture_traits[t as usize].uv
    }

    /// The index of a pigment.
    pub fn pigment(&mut self, p: &Arc<Pigment>) -> PigmentIx {
        if let Some(ix) = self.known(p, table::PIGMENT) {
            return ix;
        }
        let ix = self.pigment_entry(p);
        self.learn(p, table::PIGMENT, ix)
    }

    fn pigment_entry(&mut self, p: &Pigment) -> PigmentIx {
        let mut traits = Traits { transparent: false, uv: p.uv_mapping };
        let pattern = if matches!(p.kind, PigmentKind::Solid(_)) { NONE } else { self.pattern(&p.pattern) };
        let code = match &p.kind {
            PigmentKind::Solid(c) => {
                traits.transparent = lets_through(c);
                PigmentCode::Solid(*c)
            }
            PigmentKind::DefaultMap => {
                let spotted = matches!(p.pattern.kind, PatternKind::Spotted);
                let code = self.tables.patterns[pattern as usize].code;
                let list = default_map(&code, spotted, &self.tables.fractals);
                PigmentCode::Colors(append(&mut self.tables.color_entries, list))
            }
            PigmentKind::ColorMap(map) => {
                traits.transparent = map.entries.iter().any(|(_, c)| lets_through(c));
                PigmentCode::Colors(self.shared_range(map, table::COLORS, |b, m| append(&mut b.tables.color_entries, m.entries.clone())))
            }
            PigmentKind::PigmentMap(map) | PigmentKind::Average(map) => {
                let range = self.shared_range(map, table::PIGMENTS, Self::pigment_entries);
                let children = range.of(&self.tables.pigment_entries);
                traits = children.iter().fold(traits, |sum, (_, c)| sum.or(self.pigment_traits[*c as usize]));
                if matches!(p.kind, PigmentKind::Average(_)) { PigmentCode::Average(range) } else { PigmentCode::Map(range) }
            }
            PigmentKind::ImageMap(map) => {
                traits.transparent = image_lets_through(map);
                PigmentCode::Image(self.image(map))
            }
        };
        if let Some(c) = &p.quick_color {
            traits.transparent |= lets_through(c);
        }
        self.tables.pigments.push(PigmentNode { code, pattern, uv_mapping: p.uv_mapping, quick_color: p.quick_color });
        self.pigment_traits.push(traits);
        self.tables.pigments.len() as u32 - 1
    }

    fn pigment_entries(&mut self, map: &BlendMap<Pigment>) -> Range {
        let entries: Vec<(f32, u32)> = map.entries.iter().map(|(at, p)| (*at, self.pigment_entry(p))).collect();
        append(&mut self.tables.pigment_entries, entries)
    }

    /// The range of a map that pigments or normals share.
    fn shared_range<T: 'static>(&mut self, map: &Arc<T>, table: u8, enter: impl FnOnce(&mut Self, &T) -> Range) -> Range {
        // Two entries of `known`, since a range is two numbers.
        const LEN: u8 = 128;
        if let (Some(start), Some(len)) = (self.known(map, table), self.known(map, table | LEN)) {
            return Range { start, len };
        }
        let range = enter(self, map);
        self.learn(map, table, range.start);
        self.learn(map, table | LEN, range.len);
        range
    }

    /// The index of a normal.
    pub fn normal(&mut self, n: &Arc<Normal>) -> NormalIx {
        if let Some(ix) = self.known(n, table::NORMAL) {
            return ix;
        }
        let ix = self.normal_entry(n, false);
        self.learn(n, table::NORMAL, ix)
    }

    /// `unscaled`: the normal around it says `no_bump_scale`, which holds for all inside it too (measured).
    fn normal_entry(&mut self, n: &Normal, unscaled: bool) -> NormalIx {
        let no_bump_scale = n.no_bump_scale || unscaled;
        let mut uv = n.uv_mapping;
        let code = match &n.kind {
            NormalKind::Pattern { slope_map } => NormalCode::Pattern(slope_map.as_ref().map_or(Range::default(), |map| {
                self.shared_range(map, table::SLOPES, |b, m| append(&mut b.tables.slope_entries, m.entries.clone()))
            })),
            NormalKind::NormalMap(map) | NormalKind::Average(map) => {
                let table = if no_bump_scale { table::NORMALS_UNSCALED } else { table::NORMALS };
                let range = self.shared_range(map, table, |b, m| b.normal_entries(m, no_bump_scale));
                uv |= range.of(&self.tables.normal_entries).iter().any(|(_, c)| self.normal_uv[*c as usize]);
                if matches!(n.kind, NormalKind::Average(_)) { NormalCode::Average(range) } else { NormalCode::Map(range) }
            }
            NormalKind::BumpMap(map) => NormalCode::Bump(self.image(map)),
        };
        let pattern = self.pattern(&n.pattern);
        self.tables.normals.push(NormalNode {
            code,
            pattern,
            amount: f64::from(n.amount),
            accuracy: f64::from(n.accuracy),
            no_bump_scale,
            uv_mapping: n.uv_mapping,
        });
        self.normal_uv.push(uv);
        self.tables.normals.len() as u32 - 1
    }

    fn normal_entries(&mut self, map: &BlendMap<Normal>, unscaled: bool) -> Range {
        let entries: Vec<(f32, u32)> = map.entries.iter().map(|(at, n)| (*at, self.normal_entry(n, unscaled))).collect();
        append(&mut self.tables.normal_entries, entries)
    }

    /// The index of a picture with its mapping.
    pub fn image(&mut self, map: &Arc<ImageMap>) -> ImageIx {
        if let Some(ix) = self.known(map, table::IMAGE) {
            return ix;
        }
        self.tables.images.push(map.clone());
        self.learn(map, table::IMAGE, self.tables.images.len() as u32 - 1)
    }

    /// Enters a pattern.
    pub fn pattern(&mut self, p: &Pattern) -> PatternIx {
        let code = self.pattern_code(&p.kind);
        let turb = p.turbulence.unwrap_or_default();
        let own_turbulence = matches!(code, PatternCode::Marble | PatternCode::Wood);
        let mut warps: Vec<WarpNode> = p.warps.iter().rev().map(warp_node).collect();
        if turb.amount != DVec3::ZERO && !own_turbulence {
            warps.push(WarpNode::Turbulence { amount: turb.amount, noise: turbulence_params(&turb) });
        }
        let steps = p.warps.iter().filter_map(|w| if let Warp::Transform(t) = w { Some(t) } else { None });
        let transform = steps.fold(Transform::IDENTITY, |sum, t| sum.then(t));
        let transform_ix = if transform.is_identity() {
            NONE
        } else {
            self.tables.transforms.push(transform);
            self.tables.transforms.len() as u32 - 1
        };
        let warps = append(&mut self.tables.warps, warps);
        self.tables.patterns.push(PatternNode {
            code,
            warps,
            transform_ix,
            frequency: f64::from(p.frequency),
            phase: f64::from(p.phase),
            wave: p.wave,
            noise_generator: p.noise_generator.unwrap_or(self.tables.noise_generator),
            turb_amount: turb.amount,
            turb: turbulence_params(&turb),
        });
        self.tables.patterns.len() as u32 - 1
    }

    fn pattern_code(&mut self, kind: &PatternKind) -> PatternCode {
        match kind {
            PatternKind::Plain | PatternKind::Average => PatternCode::Plain,
            PatternKind::Agate { turb } => PatternCode::Agate { turb: f64::from(*turb) },
            PatternKind::Aoi => PatternCode::Aoi,
            PatternKind::Boxed => PatternCode::Boxed,
            PatternKind::Bozo | PatternKind::Spotted => PatternCode::Noise,
            PatternKind::Bumps => PatternCode::Bumps,
            PatternKind::Brick { size, mortar } => PatternCode::Brick { size: *size, mortar: f64::from(*mortar) },
            PatternKind::Cells => PatternCode::Cells,
            PatternKind::Checker => PatternCode::Checker,
            PatternKind::Crackle { form, metric, offset, solid } => {
                PatternCode::Crackle { form: *form, metric: *metric, offset: *offset, solid: *solid }
            }
            PatternKind::Cubic => PatternCode::Cubic,
            PatternKind::Cylindrical => PatternCode::Cylindrical,
            PatternKind::DensityFile { grid, interpolate } => {
                let ix = self.known(grid, table::GRID).unwrap_or_else(|| {
                    self.tables.grids.push(grid.clone());
                    self.learn(grid, table::GRID, self.tables.grids.len() as u32 - 1)
                });
                PatternCode::Density { grid: ix, interpolate: *interpolate }
            }
            PatternKind::Dents => PatternCode::Dents,
            PatternKind::Facets { coords, size, metric } => PatternCode::Facets { coords: *coords, size: *size, metric: *metric },
            PatternKind::Fractal(f) => {
                self.tables.fractals.push(f.clone());
                PatternCode::Fractal(self.tables.fractals.len() as u32 - 1)
            }
            PatternKind::Function(f) => PatternCode::Function(self.function(f)),
            PatternKind::Gradient(v) => PatternCode::Gradient(v.normalize_or_zero()),
            PatternKind::Granite => PatternCode::Granite,
            PatternKind::Hexagon => PatternCode::Hexagon,
            PatternKind::Image(map) => PatternCode::Image(self.image(map)),
            PatternKind::Leopard => PatternCode::Leopard,
            PatternKind::Marble => PatternCode::Marble,
            PatternKind::Object(o) => {
                self.objects.push(o.clone());
                // The place in `pattern_objects` that `set_pattern_object` will fill.
                self.tables.pattern_objects.push(NONE);
                PatternCode::Object(self.tables.pattern_objects.len() as u32 - 1)
            }
            PatternKind::Onion => PatternCode::Onion,
            PatternKind::Pavement { sides, tiles, pattern, interior, exterior, form } => PatternCode::Pavement(Pavement {
                sides: *sides,
                interior: *interior,
                exterior: *exterior,
                form: *form,
                layout: layout_of(*sides, *tiles, *pattern),
            }),
            PatternKind::Pigment(p) => {
                let ix = self.pigment(p);
                self.uv_in_pattern |= self.pigment_traits[ix as usize].uv;
                PatternCode::Pigment(ix)
            }
            PatternKind::Planar => PatternCode::Planar,
            PatternKind::Quilted { control0, control1 } => {
                PatternCode::Quilted { control0: f64::from(*control0), control1: f64::from(*control1) }
            }
            PatternKind::Radial => PatternCode::Radial,
            PatternKind::Ripples => PatternCode::Ripples,
            PatternKind::Slope { direction, point_at, low, high, altitude } => {
                let slope_len = if *point_at { 1.0 } else { direction.length() };
                self.tables.slopes.push(SlopeParams {
                    direction: if *point_at { *direction } else { direction.normalize_or_zero() },
                    point_at: *point_at,
                    low: *low,
                    high: *high,
                    altitude: altitude
                        .map(|(a, lo, hi)| (a.normalize_or_zero(), lo, hi, slope_len / (slope_len + a.length()).max(f64::MIN_POSITIVE))),
                });
                PatternCode::Slope(self.tables.slopes.len() as u32 - 1)
            }
            PatternKind::Spherical => PatternCode::Spherical,
            PatternKind::Spiral1 { arms } => PatternCode::Spiral1 { arms: f64::from(*arms) },
            PatternKind::Spiral2 { arms } => PatternCode::Spiral2 { arms: f64::from(*arms) },
            PatternKind::Square => PatternCode::Square,
            PatternKind::Tiling(n) => PatternCode::Tiling(*n),
            PatternKind::Triangular => PatternCode::Triangular,
            PatternKind::Waves => PatternCode::Waves,
            PatternKind::Wood => PatternCode::Wood,
            PatternKind::Wrinkles => PatternCode::Wrinkles,
        }
    }

    /// The index of a user function.
    pub fn function(&mut self, f: &Arc<Function>) -> FunctionIx {
        if let Some(ix) = self.known(f, table::FUNCTION) {
            return ix;
        }
        let node = match &f.body {
            FunctionBody::Expr(e) => {
                let ix = compile_expr(self, e, f.n_params);
                return self.learn(f, table::FUNCTION, ix);
            }
            FunctionBody::Internal(n) => FunctionNode::Internal(*n),
            FunctionBody::Pigment(p) => FunctionNode::Pigment(self.pigment(p)),
            FunctionBody::Pattern(p) => FunctionNode::Pattern(self.pattern(p)),
            FunctionBody::Transform(t) => {
                self.tables.function_transforms.push(*t);
                FunctionNode::Transform(self.tables.function_transforms.len() as u32 - 1)
            }
            FunctionBody::Spline(s) => FunctionNode::Spline(self.spline(s)),
        };
        let ix = self.add_function(node);
        self.learn(f, table::FUNCTION, ix)
    }

    fn add_function(&mut self, node: FunctionNode) -> FunctionIx {
        self.tables.functions.push(node);
        self.tables.functions.len() as u32 - 1
    }

    /// An expression that is compiled already.
    pub(crate) fn compiled(&self, key: &FunctionKey) -> Option<FunctionIx> {
        self.compiled.get(key).copied()
    }

    /// Enters a compiled expression.
    pub(crate) fn add_compiled(&mut self, key: FunctionKey, node: FunctionNode) -> FunctionIx {
        let ix = self.add_function(node);
        self.compiled.insert(key, ix);
        ix
    }

    /// The tables so far.
    pub(crate) fn tables(&mut self) -> &mut TextureTables {
        &mut self.tables
    }

    fn spline(&mut self, s: &Spline) -> u32 {
        let knots = s.knots.iter().zip(second_derivatives(s)).map(|((t, value), second)| Knot { t: *t, value: *value, second });
        let knots = append(&mut self.tables.knots, knots.collect());
        self.tables.splines.push(SplineNode { kind: s.kind, n_components: s.n_components as u8, knots });
        self.tables.splines.len() as u32 - 1
    }

    /// Objects of object patterns that were entered since the last call, for the geometry to compile as hidden objects.
    pub fn take_objects(&mut self) -> Vec<Arc<Object>> {
        std::mem::take(&mut self.objects)
    }

    /// Says where the next object that [`TextureBuilder::take_objects`] gave stands in `Geometry::objects`; in the order given.
    pub fn set_pattern_object(&mut self, object_ix: u32) {
        if let Some(slot) = self.tables.pattern_objects.iter_mut().find(|o| **o == NONE) {
            *slot = object_ix;
        }
    }

    /// The finished tables.
    pub fn finish(mut self) -> TextureTables {
        self.tables.wave_sources = wave_sources(self.number_of_waves);
        self.tables
    }
}

/// Sources and frequencies of waves and ripples. Source: FACTS.md, section 2.
fn wave_sources(n: u32) -> Vec<(DVec3, f64)> {
    let mut seed = (-560_851_967i32) as u32;
    (0..n)
        .map(|i| {
            let place = noise_vector(DVec3::new(f64::from(i), 0.0, 0.0)).normalize_or_zero();
            seed = lcg_step(seed);
            (place, f64::from((seed >> 16) & 0x7FFF) * 0.000_030_518_509_476 + 0.01)
        })
        .collect()
}

fn append<T>(table: &mut Vec<T>, list: Vec<T>) -> Range {
    let start = table.len() as u32;
    let len = list.len() as u32;
    table.extend(list);
    Range { start, len }
}

fn lets_through(c: &Rgbft) -> bool {
    c.filter != 0.0 || c.transmit != 0.0
}

fn image_lets_through(map: &ImageMap) -> bool {
    let palette = if let Pixels::Indexed { palette, .. } = &map.image.pixels { palette.as_slice() } else { &[] };
    map.once || map.image.has_alpha || map.filter_all != 0.0 || map.transmit_all != 0.0 || palette.iter().any(lets_through)
}

fn turbulence_params(t: &Turbulence) -> TurbulenceParams {
    TurbulenceParams { octaves: t.octaves.clamp(1, 10), omega: t.omega, lambda: t.lambda }
}

fn warp_node(w: &Warp) -> WarpNode {
    match *w {
        Warp::Transform(t) => WarpNode::Affine(t.inverse),
        // The width is a 32-bit number (measured).
        Warp::Repeat { axis, width, offset, flip } => WarpNode::Repeat { axis, width: f64::from(width as f32), offset, flip },
        Warp::BlackHole { center, radius, strength, falloff, inverse, repeat, turbulence } => WarpNode::BlackHole {
            center,
            radius,
            strength,
            inverse,
            falloff,
            repeat: repeat.unwrap_or(DVec3::ZERO),
            repeats: repeat.is_some(),
            turbulence,
        },
        Warp::Turbulence(t) => WarpNode::Turbulence { amount: t.amount, noise: turbulence_params(&t) },
        Warp::Cylindrical { orientation, dist_exp } => WarpNode::Cylindrical { orientation, dist_exp },
        Warp::Spherical { orientation, dist_exp } => WarpNode::Spherical { orientation, dist_exp },
        Warp::Toroidal { orientation, dist_exp, major_radius } => WarpNode::Toroidal { orientation, dist_exp, major_radius },
        Warp::Planar { orientation, distance } => WarpNode::Planar { orientation, distance },
        Warp::Cubic => WarpNode::Cubic,
    }
}
