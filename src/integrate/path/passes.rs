//! Passes of a pixel: what its samples leave besides the colour, gathered while they are traced.
//!
//! Which light counts as what is Cycles' way: by the lobes of the first bounce; "direct" is light of a lamp, a shining face or the world that
//! bounced once. Colours and names are those of all surfaces that the camera's ray passes on its way to the first bounce.

use super::catcher::{Part, mean};
use super::closure::Shading;
use super::plan::PathPlan;
use super::surface::Surface;
use super::trace::Path;
use crate::compile::CompiledScene;
use crate::compile::texture::TextureNode;
use crate::film::cryptomatte::name_bits;
use crate::film::{add_share, write_ranks};
use crate::math::{Rgb, Vec3};
use crate::scene::pass::{CRYPTO_RANKS, Join, NO_DEPTH};
use crate::scene::{Pass, PassSet, Shader};

/// Least alpha of a surface that has a depth, an index and a normal. Source: Blender's default "alpha threshold".
const ALPHA_THRESHOLD: f32 = 0.5;

/// Where light comes from.
#[derive(Clone, Copy, Debug)]
pub(super) enum From {
    /// A lamp or something shining that the ray met.
    Met,
    /// The world that the ray met.
    World,
    /// A light that was drawn for the place where the path is.
    Drawn(Shares),
}

/// What the first bounce was.
#[derive(Clone, Copy, Debug)]
pub(super) enum Shares {
    /// Shares of diffuse and glossy lobes; the rest went through.
    Surface([Rgb; 2]),
    Volume,
}

impl Shares {
    pub const DIFFUSE: Self = Self::Surface([Vec3::ONE, Vec3::ZERO]);
}

/// Hashes of names as Cryptomatte keeps them.
#[derive(Debug, Default)]
pub(super) struct NameTable {
    /// By object.
    objects: Vec<u32>,
    assets: Vec<u32>,
    /// By entry of `TextureTables::textures`.
    materials: Vec<u32>,
}

/// Names of a scene's objects, their topmost parents, or materials: by object, or by entry of `TextureTables::textures`.
fn names(scene: &CompiledScene, pass: Pass) -> Vec<String> {
    let objects = || scene.geometry.objects.iter().enumerate();
    let own = |k: usize, name: &str| if name.is_empty() { format!("object {k}") } else { name.to_owned() };
    match pass {
        Pass::CryptoObject => objects().map(|(k, o)| own(k, &o.traits.name)).collect(),
        Pass::CryptoAsset => {
            objects().map(|(k, o)| if o.traits.asset.is_empty() { own(k, &o.traits.name) } else { o.traits.asset.to_string() }).collect()
        }
        Pass::CryptoMaterial => {
            let name = |(k, t): (usize, &TextureNode)| match t {
                TextureNode::Principled(ix) => {
                    let p = &scene.textures.principled[*ix as usize];
                    let name = p.shader.as_ref().map_or(&*p.name, |s| &s.name);
                    if name.is_empty() { format!("material {k}") } else { name.to_owned() }
                }
                _ => format!("texture {k}"),
            };
            scene.textures.textures.iter().enumerate().map(name).collect()
        }
        _ => Vec::new(),
    }
}

/// Header attributes of the Cryptomatte passes among `passes`: name and text of each.
pub fn manifests(scene: &CompiledScene, passes: PassSet, view_layer: &str) -> Vec<(String, String)> {
    let of = |pass: Pass| {
        let list = names(scene, pass);
        crate::film::cryptomatte::attributes(&format!("{view_layer}.{}", pass.layer()), list.iter().map(String::as_str))
    };
    passes.iter().filter(|p| p.join() == Join::Crypto).flat_map(of).collect()
}

impl NameTable {
    pub fn new(scene: &CompiledScene, passes: PassSet) -> Self {
        let of = |pass| {
            if !passes.has(pass) {
                return Vec::new();
            }
            names(scene, pass).iter().map(|n| name_bits(n)).collect()
        };
        Self { objects: of(Pass::CryptoObject), assets: of(Pass::CryptoAsset), materials: of(Pass::CryptoMaterial) }
    }
}

/// Sums over the samples of a pixel.
pub(super) struct Gather {
    passes: PassSet,
    /// Place of each pass in a pixel's values.
    places: [usize; 32],
    /// Of the sample under way.
    sample: Vec<f32>,
    sample_names: Vec<(Pass, u32, f32)>,
    met: bool,
    /// What is seen so far is all mirrors and clear glass: the colour of it, for the denoiser's guides.
    clear: Option<Rgb>,
    /// Of all samples so far.
    sums: Vec<f64>,
    names: [Vec<(u32, f64)>; 3],
    squares: [f64; 3],
    colors: [f64; 3],
    n: u32,
}

fn names_place(p: Pass) -> usize {
    p as usize - Pass::CryptoObject as usize
}

impl Gather {
    pub fn new(passes: PassSet) -> Self {
        let (mut places, mut width) = ([0; 32], 0);
        for p in passes.iter() {
            places[p as usize] = width;
            width += p.width();
        }
        Self {
            passes,
            places,
            sample: vec![0.0; width],
            sample_names: Vec::new(),
            met: false,
            clear: None,
            sums: vec![0.0; width],
            names: Default::default(),
            squares: [0.0; 3],
            colors: [0.0; 3],
            n: 0,
        }
    }

    /// Before the first sample of a pixel.
    pub fn start_pixel(&mut self) {
        self.sums.fill(0.0);
        self.names.iter_mut().for_each(Vec::clear);
        (self.squares, self.colors, self.n) = ([0.0; 3], [0.0; 3], 0);
    }

    /// Before a sample.
    pub fn start_sample(&mut self) {
        self.sample.fill(0.0);
        self.sample_names.clear();
        self.met = false;
        self.clear = self.passes.has_any(&[Pass::Albedo, Pass::DenoisingNormal]).then_some(Vec3::ONE);
        self.put(Pass::Depth, &[NO_DEPTH]);
        self.put(Pass::Mist, &[1.0]);
    }

    fn put(&mut self, p: Pass, values: &[f32]) {
        if self.passes.has(p) {
            let at = self.places[p as usize];
            self.sample[at..at + values.len()].copy_from_slice(values);
        }
    }

    fn add(&mut self, p: Pass, color: Rgb) {
        if self.passes.has(p) {
            let at = self.places[p as usize];
            self.sample[at..at + 3].iter_mut().zip(color.to_array()).for_each(|(v, c)| *v += c);
        }
    }

    /// Whether the denoiser's guides of the sample are not known yet.
    pub fn wants_guides(&self) -> bool {
        self.clear.is_some()
    }

    /// A surface that the path meets, for the denoiser's guides: where a quarter or more of what it does is rough, they are its colour and its normal in the
    /// camera's axes; else they are those of what is seen in it. Source: which that is, and that light counts, Cycles' passes (measured).
    pub fn guide(&mut self, plan: &PathPlan, path: &Path, surface: &Surface, shading: &Shading) {
        let Some(seen_in) = self.clear else { return };
        let ([mut rough, smooth], mut chance) = shading.lobes.rough_and_smooth(surface.v);
        let mut total = shading.lobes.total_chance() + mean(shading.transparent);
        if let Some(s) = &shading.subsurface {
            rough += s.weight;
            chance += mean(s.weight);
            total += mean(s.weight);
        }
        if total > 0.0 && 4.0 * chance <= total {
            self.clear = Some(seen_in * (smooth + shading.transparent));
            return;
        }
        self.clear = None;
        self.add(Pass::Albedo, seen_in * rough);
        if total > 0.0 {
            self.put(Pass::DenoisingNormal, &plan.camera.to_view(shading.mean_normal(surface), path.time).to_array());
        }
    }

    /// The path scatters in a volume before it meets a surface.
    pub fn guide_volume(&mut self, color: Rgb) {
        if let Some(seen_in) = self.clear.take() {
            self.add(Pass::Albedo, seen_in * color);
        }
    }

    /// The camera's path meets its first shadow catcher with so much of it left; `behind` is the world's light from there.
    pub fn catcher_met(&mut self, share: f32, behind: Rgb) {
        self.add_at(Pass::ShadowCatcher, 6, &[share]);
        self.add_at(Pass::ShadowCatcher, 7, &behind.to_array());
    }

    /// Nothing of a path that met no catcher blocks so much of the film.
    pub fn left_open(&mut self, share: f32, part: Part) {
        if part == Part::Before {
            self.add_at(Pass::ShadowCatcher, 6, &[share]);
        }
    }

    /// Light for the sums of catchers.
    pub fn catcher_light(&mut self, light: Rgb, part: Part) {
        match part {
            Part::Alone => self.add_at(Pass::ShadowCatcher, 0, &light.to_array()),
            Part::Before => self.add_at(Pass::ShadowCatcher, 3, &light.to_array()),
            Part::After => {}
        }
    }

    fn add_at(&mut self, p: Pass, first: usize, values: &[f32]) {
        if self.passes.has(p) {
            let at = self.places[p as usize] + first;
            self.sample[at..at + values.len()].iter_mut().zip(values).for_each(|(v, x)| *v += x);
        }
    }

    /// Whether a pass is wanted.
    pub fn wants(&self, p: Pass) -> bool {
        self.passes.has(p)
    }

    /// Light of the picture; `bounces` are those of the path, `first` what its first was.
    pub fn light(&mut self, light: Rgb, from: From, bounces: u32, first: Shares) {
        if let (Some(seen_in), From::Met | From::World) = (self.clear, from) {
            self.add(Pass::Albedo, seen_in * light);
        }
        let (shares, is_direct) = match (from, bounces) {
            (From::Met, 0) => return self.add(Pass::Emission, light),
            (From::World, 0) => return self.add(Pass::Environment, light),
            (From::Met | From::World, n) => (first, n == 1),
            (From::Drawn(here), 0) => (here, true),
            (From::Drawn(_), _) => (first, false),
        };
        let either = |direct, indirect| if is_direct { direct } else { indirect };
        match shares {
            Shares::Volume => self.add(either(Pass::VolumeDirect, Pass::VolumeIndirect), light),
            Shares::Surface([diffuse, glossy]) => {
                self.add(either(Pass::DiffuseDirect, Pass::DiffuseIndirect), light * diffuse);
                self.add(either(Pass::GlossyDirect, Pass::GlossyIndirect), light * glossy);
                let rest = (Vec3::ONE - diffuse - glossy).max(Vec3::ZERO);
                self.add(either(Pass::TransmissionDirect, Pass::TransmissionIndirect), light * rest);
            }
        }
    }

    /// A surface on the camera's ray, before the first bounce.
    /// `openness` is that of the place, for ambient occlusion.
    pub fn surface(&mut self, plan: &PathPlan, path: &Path, surface: &Surface, shading: &Shading, shader: Option<&Shader>, openness: f32) {
        let opacity = 1.0 - (shading.transparent.element_sum() / 3.0).clamp(0.0, 1.0);
        if !self.met && opacity >= ALPHA_THRESHOLD {
            self.met = true;
            let p = surface.hit.point;
            self.put(Pass::Depth, &[plan.camera.depth(p, path.time) as f32]);
            self.put(Pass::Position, &p.as_vec3().to_array());
            self.put(Pass::Normal, &shading.mean_normal(surface).to_array());
            if surface.has_uv(0) {
                let uv = surface.uv(0);
                self.put(Pass::Uv, &[uv.x as f32, 1.0 - uv.y as f32, 1.0]);
            }
            if self.wants(Pass::Vector) {
                let weight = mean(path.throughput);
                let [a, b, c, d] = plan.motion_vector(surface, path.time).map(|v| v * weight);
                self.put(Pass::Vector, &[a, b, c, d, weight]);
            }
            let object = plan.scene.geometry.objects.get(surface.prim.object_ix as usize);
            self.put(Pass::ObjectId, &[object.map_or(0, |o| o.traits.object_id) as f32]);
            self.put(Pass::MaterialId, &[shader.map_or(0, |s| s.material_id) as f32]);
        }
        let share = mean(path.throughput) * opacity;
        if self.wants(Pass::Mist) {
            self.add_at(Pass::Mist, 0, &[-share * (1.0 - plan.mist(surface.hit.point, path.time))]);
        }
        self.add(Pass::AmbientOcclusion, Vec3::splat(share * openness));
        if self.passes.has_any(&[Pass::DiffuseColor, Pass::GlossyColor, Pass::TransmissionColor]) {
            let [mut diffuse, glossy, through] = shading.lobes.colors(surface.v);
            if let Some(s) = &shading.subsurface {
                diffuse += s.weight;
            }
            self.add(Pass::DiffuseColor, path.throughput * diffuse);
            self.add(Pass::GlossyColor, path.throughput * glossy);
            self.add(Pass::TransmissionColor, path.throughput * through);
        }
        if share > 0.0 {
            let names = &plan.names;
            let object = surface.prim.object_ix as usize;
            let cover = plan.cover_ix(surface).map_or(usize::MAX, |k| k as usize);
            for (pass, id) in [
                (Pass::CryptoObject, names.objects.get(object)),
                (Pass::CryptoAsset, names.assets.get(object)),
                (Pass::CryptoMaterial, names.materials.get(cover)),
            ] {
                if let (true, Some(id)) = (self.passes.has(pass), id) {
                    self.sample_names.push((pass, *id, share));
                }
            }
        }
    }

    /// After a sample whose colour is `c`; `counts`: it was finite.
    pub fn end_sample(&mut self, c: [f32; 4], counts: bool) {
        if !counts {
            // Its light is nowhere, as in the picture.
            self.sample.fill(0.0);
            self.sample_names.clear();
            self.put(Pass::Depth, &[NO_DEPTH]);
            self.put(Pass::Mist, &[1.0]);
        }
        let first = self.n == 0;
        for p in self.passes.iter() {
            let range = self.places[p as usize]..self.places[p as usize] + p.width();
            match p.join() {
                Join::First if first => range.for_each(|k| self.sums[k] = f64::from(self.sample[k])),
                Join::Mean => range.for_each(|k| self.sums[k] += f64::from(self.sample[k])),
                _ => {}
            }
        }
        for (pass, id, share) in self.sample_names.drain(..) {
            add_share(&mut self.names[names_place(pass)], id, f64::from(share));
        }
        for k in 0..3 {
            self.colors[k] += f64::from(c[k]);
            self.squares[k] += f64::from(c[k]) * f64::from(c[k]);
        }
        self.n += 1;
    }

    /// Values of the pixel, in the order of the film's layers.
    pub fn pixel(&mut self) -> Vec<f32> {
        let n = f64::from(self.n.max(1));
        let mut out = vec![0.0f32; self.sums.len()];
        for p in self.passes.iter() {
            let at = self.places[p as usize];
            let range = at..at + p.width();
            match p.join() {
                Join::First => range.for_each(|k| out[k] = self.sums[k] as f32),
                Join::Mean => range.for_each(|k| out[k] = (self.sums[k] / n) as f32),
                Join::Variance => {
                    for k in 0..3 {
                        let squares = self.squares[k] - self.colors[k] * self.colors[k] / n;
                        out[at + k] = if self.n > 1 { (squares / (n - 1.0)).max(0.0) as f32 } else { 0.0 };
                    }
                }
                Join::Crypto => {
                    let shares = &mut self.names[names_place(p)];
                    shares.iter_mut().for_each(|s| s.1 /= n);
                    write_ranks(shares, &mut out[at..at + 2 * CRYPTO_RANKS]);
                }
                Join::Count => {}
            }
        }
        out
    }
}
