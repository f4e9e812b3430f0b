//! What surfaces do to light, one kind of lobe a file, and a set of lobes as one thing to evaluate and sample.
//!
//! `v` points to the viewer, `l` to the light; both are unit and leave the surface. Values hold the cosine of the light. Nothing here knows
//! of scenes. Conventions where a choice is open: Cycles' (docs/path.md).

pub mod albedo;
pub mod diffuse;
pub mod frame;
pub mod fresnel;
pub mod ggx;
pub mod hair;
pub mod microfacet;
pub mod sheen;
#[cfg(test)]
pub(crate) mod tests;
pub mod thin_film;

use crate::math::{Rgb, Vec3};
use crate::scene::Visibility;
use arrayvec::ArrayVec;
use diffuse::OrenNayar;
use frame::{Frame, cosine_hemisphere};
use hair::Hair;
use microfacet::Microfacet;
use sheen::Sheen;
use std::f32::consts::{FRAC_1_PI, PI};

/// Stands for the density of a mirror's one direction: large, so that mixed lobes weigh as they should.
pub const SINGULAR_DENSITY: f32 = 1e6;

/// What a bounce was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Event {
    Diffuse,
    Glossy,
    /// Through the surface, bent or scattered.
    Transmission,
}

/// One kind of answer.
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "the names say it")]
pub enum LobeKind {
    Lambert,
    OrenNayar(OrenNayar),
    /// Lambert on the far side.
    Translucent,
    Microfacet(Microfacet),
    Sheen(Sheen),
    Hair(Hair),
}

/// A weighted lobe about a normal of its own.
#[derive(Clone, Copy, Debug)]
pub struct Lobe {
    /// Multiplies the value.
    pub weight: Rgb,
    /// Chance to be sampled, relative to the others.
    pub chance: f32,
    /// Its frame.
    pub frame: Frame,
    /// Its kind.
    pub kind: LobeKind,
    /// Factor of diffuse light from beyond a bent normal's own horizon is applied (the frame is not the smooth surface's).
    pub is_bent: bool,
}

/// A direction drawn in the frame of a lobe.
#[derive(Clone, Copy, Debug)]
pub struct LocalSample {
    /// To the light.
    pub l: Vec3,
    /// Value times cosine.
    pub value: Rgb,
    /// Per solid angle.
    pub pdf: f32,
    /// A mirror's one direction.
    pub singular: bool,
    /// What the bounce counts as, where the direction alone does not say.
    pub event: Option<Event>,
}

/// A direction drawn from a set of lobes.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// To the light, unit, in the world.
    pub l: Vec3,
    /// Value times cosine of all lobes.
    pub value: Rgb,
    /// Density of all lobes.
    pub pdf: f32,
    /// What happened.
    pub event: Event,
    /// A mirror's one direction.
    pub singular: bool,
    /// Width of the lobe (roughness squared) that was drawn from: 1 for diffuse ones.
    pub width: f32,
}

/// Width (roughness squared) up to which a lobe is a mirror or clear glass for denoisers: what is seen in it is the guide. Source: Cycles (measured).
const MIRROR_WIDTH: f32 = 0.075;

impl Lobe {
    /// Colour by kind: diffuse, reflected, let through.
    fn colors(&self, v: Vec3) -> [Rgb; 3] {
        let cos = self.frame.n.dot(v).clamp(0.0, 1.0);
        match &self.kind {
            LobeKind::Lambert | LobeKind::OrenNayar(_) | LobeKind::Translucent => [self.weight, Vec3::ZERO, Vec3::ZERO],
            LobeKind::Sheen(s) => [self.weight * s.albedo, Vec3::ZERO, Vec3::ZERO],
            LobeKind::Microfacet(m) => {
                let [reflected, through] = m.albedo(cos);
                [Vec3::ZERO, self.weight * reflected, self.weight * through]
            }
            // Half each way.
            LobeKind::Hair(_) => [Vec3::ZERO, self.weight * 0.5, self.weight * 0.5],
        }
    }

    fn is_rough(&self) -> bool {
        match &self.kind {
            LobeKind::Microfacet(m) => m.ggx.ax * m.ggx.ay > MIRROR_WIDTH * MIRROR_WIDTH,
            _ => true,
        }
    }

    /// Value without the weight, and density.
    fn eval(&self, v: Vec3, l: Vec3) -> (Rgb, f32) {
        let (v, l) = (self.frame.to_local(v), self.frame.to_local(l));
        match &self.kind {
            LobeKind::Lambert => {
                let d = l.z.max(0.0) * FRAC_1_PI;
                (Vec3::splat(d), d)
            }
            LobeKind::OrenNayar(_) if l.z <= 0.0 => (Vec3::ZERO, 0.0),
            LobeKind::OrenNayar(o) => (o.eval(v, l), l.z * FRAC_1_PI),
            LobeKind::Translucent => {
                let d = (-l.z).max(0.0) * FRAC_1_PI;
                (Vec3::splat(d), d)
            }
            LobeKind::Microfacet(m) => m.eval(v, l),
            LobeKind::Sheen(s) => {
                let d = s.pdf(l);
                (Vec3::splat(d * s.albedo), d)
            }
            LobeKind::Hair(h) => h.eval(v, l),
        }
    }

    fn sample(&self, v: Vec3, [u, w, pick]: [f32; 3]) -> Option<LocalSample> {
        let v = self.frame.to_local(v);
        let one = |l: Vec3, value: Rgb, pdf: f32| (pdf > 0.0).then_some(LocalSample { l, value, pdf, singular: false, event: None });
        let s = match &self.kind {
            LobeKind::Lambert => {
                let l = cosine_hemisphere(u, w);
                one(l, Vec3::splat(l.z / PI), l.z / PI)
            }
            LobeKind::OrenNayar(o) => {
                let l = cosine_hemisphere(u, w);
                one(l, o.eval(v, l), l.z / PI)
            }
            LobeKind::Translucent => {
                let l = cosine_hemisphere(u, w);
                one(Vec3::new(l.x, l.y, -l.z), Vec3::splat(l.z / PI), l.z / PI)
            }
            LobeKind::Microfacet(m) => m.sample(v, u, w, pick),
            LobeKind::Sheen(s) => {
                let l = s.sample(u, w);
                let d = s.pdf(l);
                one(l, Vec3::splat(d * s.albedo), d)
            }
            LobeKind::Hair(h) => h.sample(u, w, pick),
        }?;
        Some(LocalSample { l: self.frame.to_world(s.l), ..s })
    }

    /// What a bounce to `l` counts as.
    fn event(&self, l: Vec3) -> Event {
        match &self.kind {
            LobeKind::Lambert | LobeKind::OrenNayar(_) | LobeKind::Sheen(_) => Event::Diffuse,
            LobeKind::Translucent => Event::Transmission,
            LobeKind::Microfacet(_) if l.dot(self.frame.n) < 0.0 => Event::Transmission,
            LobeKind::Hair(h) => h.event(self.frame.to_local(l)),
            LobeKind::Microfacet(_) => Event::Glossy,
        }
    }

    /// Whether its normal is that of the flat face.
    fn is_flat(&self, flat: Vec3) -> bool {
        matches!(self.kind, LobeKind::Hair(_)) || self.frame.n.dot(flat) > 0.999_999
    }

    /// Share of what is mirrored below the flat face that comes back up: width cubed for reflection, else none. Source: fitted to Cycles'
    /// measured shares 0.03, 0.27, 0.54 and 1 at roughness 0.5, 0.8, 0.9 and 1.
    fn flips(&self) -> f32 {
        match &self.kind {
            LobeKind::Microfacet(m) if !m.refracts && m.ggx.ax * m.ggx.ay > 0.01 => (m.ggx.ax * m.ggx.ay).powf(1.5),
            _ => 0.0,
        }
    }

    fn width(&self) -> f32 {
        match &self.kind {
            LobeKind::Microfacet(m) => (m.ggx.ax * m.ggx.ay).sqrt(),
            LobeKind::Hair(_) => 0.3,
            _ => 1.0,
        }
    }

    fn is_diffuse(&self) -> bool {
        matches!(self.kind, LobeKind::Lambert | LobeKind::OrenNayar(_) | LobeKind::Translucent | LobeKind::Sheen(_))
    }

    /// Whether light from a direction can be asked for.
    fn is_smooth(&self) -> bool {
        !matches!(&self.kind, LobeKind::Microfacet(m) if m.ggx.is_singular())
    }
}

/// Most lobes of a surface; what exceeds them is left out, the weakest first come first served.
pub const MAX_LOBES: usize = 12;

/// All lobes of a surface at a point.
#[derive(Clone, Debug)]
pub struct LobeSet {
    /// In place, and what is not used is not written.
    lobes: ArrayVec<Lobe, MAX_LOBES>,
    total: f32,
    /// Smooth shading normal, unit, on the viewer's side.
    pub normal: Vec3,
    /// Normal of the flat face, on the viewer's side.
    pub flat: Vec3,
}

/// Dims diffuse light where a bent normal faces it but the surface does not: the shadowing of facets as rough as the normal is bent.
/// Source: Conty Estevez, Lecocq and Stein 2019, "A microfacet-based shadowing function to solve the bump terminator problem"; that Cycles 4.5
/// has this form, measured (`tests/measured/cycles_bent.txt`).
fn bump_shadow(smooth: Vec3, bent: Vec3, l: Vec3) -> f32 {
    let tan_sq = |cos: f32| (1.0 - cos * cos).max(0.0) / (cos * cos).max(1e-12);
    let (cos_bend, cos) = (smooth.dot(bent), smooth.dot(l));
    // Light from behind both is translucent light's.
    let same_side = (cos > 0.0) == (bent.dot(l) > 0.0);
    if !same_side {
        return 0.0;
    }
    let width_sq = (0.125 * tan_sq(cos_bend)).clamp(0.0, 1.0);
    2.0 / (1.0 + (1.0 + width_sq * tan_sq(cos)).sqrt())
}

impl LobeSet {
    /// No lobes yet.
    pub fn new(normal: Vec3, flat: Vec3) -> Self {
        Self { lobes: ArrayVec::new(), total: 0.0, normal, flat }
    }

    /// Adds a lobe unless it is black.
    pub fn push(&mut self, lobe: Lobe) {
        if !self.lobes.is_full() && lobe.chance > 0.0 && lobe.weight.max_element() > 0.0 {
            self.total += lobe.chance;
            self.lobes.push(lobe);
        }
    }

    /// The lobes.
    pub fn lobes(&self) -> impl Iterator<Item = &Lobe> {
        self.lobes.iter()
    }

    /// Makes mirror lobes and hair at least so wide (roughness squared); their weights stay as they are. Source: Cycles (suite
    /// `path/transport/filter_glossy`).
    pub fn widen(&mut self, least: f32) {
        if least <= 0.0 {
            return;
        }
        for lobe in &mut self.lobes {
            match &mut lobe.kind {
                LobeKind::Microfacet(m) => m.ggx = ggx::Ggx { ax: m.ggx.ax.max(least), ay: m.ggx.ay.max(least) },
                LobeKind::Hair(h) => h.widen(least),
                _ => {}
            }
        }
    }

    /// Whether there is nothing.
    pub fn is_empty(&self) -> bool {
        self.lobes.is_empty()
    }

    /// Sum of the chances.
    pub fn total_chance(&self) -> f32 {
        self.total
    }

    /// Whether light from a given direction can be reflected at all.
    pub fn is_smooth(&self) -> bool {
        self.lobes().any(Lobe::is_smooth)
    }

    /// Value without the weight, and density, where the lobe's normal is not the flat face's: of microfacets, light on the other side of the
    /// face than of the lobe's own plane is lost. Light that is `met` by chance rather than asked for has exceptions: of what the widest mirror
    /// lobes send below the face, the share [`Lobe::flips`] is mirrored back up, and diffuse lobes lose such light too
    /// ([`LobeSet::sample_lobe`]). Source: what Cycles does with one sample, measured (`tests/measured/cycles_bent.txt`, suite `path/diffuse`;
    /// under suns its reflection is GGX and nothing more).
    fn eval_lobe(&self, lobe: &Lobe, v: Vec3, l: Vec3, met: bool) -> (Rgb, f32) {
        if lobe.is_flat(self.flat) || lobe.is_diffuse() {
            return lobe.eval(v, l);
        }
        let height = l.dot(self.flat);
        if (l.dot(lobe.frame.n) > 0.0) != (height > 0.0) {
            return (Vec3::ZERO, 0.0);
        }
        let (mut f, mut p) = lobe.eval(v, l);
        let flips = lobe.flips();
        let mirrored = l - self.flat * (2.0 * height);
        if flips > 0.0 && height > 0.0 && mirrored.dot(lobe.frame.n) > 0.0 {
            let (more, pdf) = lobe.eval(v, mirrored);
            // The density is that of the sampler in either case.
            p += pdf * flips;
            if met {
                f += more * flips;
            }
        }
        (f, p)
    }

    /// A direction of a lobe as [`LobeSet::eval_lobe`] sees it.
    fn sample_lobe(&self, lobe: &Lobe, v: Vec3, u: [f32; 3]) -> Option<LocalSample> {
        let s = lobe.sample(v, u)?;
        if lobe.is_flat(self.flat) {
            return Some(s);
        }
        let flips = lobe.flips();
        let height = s.l.dot(self.flat);
        let is_lost = (s.l.dot(lobe.frame.n) > 0.0) != (height > 0.0);
        if is_lost && !(height < 0.0 && u[2] < flips) {
            return None;
        }
        if flips <= 0.0 || s.singular {
            return Some(s);
        }
        let l = if is_lost { s.l - self.flat * (2.0 * height) } else { s.l };
        let (value, pdf) = self.eval_lobe(lobe, v, l, true);
        (pdf > 0.0).then_some(LocalSample { l, value, pdf, ..s })
    }

    fn shade(&self, lobe: &Lobe, l: Vec3) -> f32 {
        if lobe.is_bent && lobe.is_diffuse() { bump_shadow(self.normal, lobe.frame.n, l) } else { 1.0 }
    }

    /// Value and density of a direction.
    #[inline]
    pub fn eval(&self, v: Vec3, l: Vec3) -> (Rgb, f32) {
        self.eval_but(v, l, usize::MAX, false)
    }

    /// Value and density for a light that only some kinds of rays see; the density is that of all lobes.
    #[inline]
    pub fn eval_for(&self, v: Vec3, l: Vec3, visibility: Visibility) -> (Rgb, f32) {
        let all = Visibility::DIFFUSE.with(Visibility::GLOSSY).with(Visibility::TRANSMISSION);
        if visibility.has(all) {
            return self.eval(v, l);
        }
        let (mut value, mut pdf) = (Vec3::ZERO, 0.0);
        for lobe in self.lobes() {
            let (f, p) = self.eval_lobe(lobe, v, l, false);
            pdf += p * lobe.chance;
            let kind = match lobe.event(l) {
                Event::Diffuse => Visibility::DIFFUSE,
                Event::Glossy => Visibility::GLOSSY,
                Event::Transmission => Visibility::TRANSMISSION,
            };
            if visibility.has(kind) {
                value += f * lobe.weight * self.shade(lobe, l);
            }
        }
        (value, pdf / self.total)
    }

    /// Shares of the value towards `l` that diffuse and glossy lobes have; the rest goes through. Translucent light counts as diffuse.
    /// Source: which closure counts as what, Cycles' passes.
    pub fn shares(&self, v: Vec3, l: Vec3) -> [Rgb; 2] {
        let (mut all, mut diffuse, mut glossy) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
        for lobe in self.lobes() {
            let f = self.eval_lobe(lobe, v, l, false).0 * lobe.weight * self.shade(lobe, l);
            all += f;
            if lobe.is_diffuse() {
                diffuse += f;
            } else if lobe.event(l) == Event::Glossy {
                glossy += f;
            }
        }
        let of = |part: Rgb| Vec3::select(all.cmpgt(Vec3::ZERO), part / all, Vec3::ZERO);
        [of(diffuse), of(glossy)]
    }

    /// Colours: what all lobes together give back of white light from everywhere, by kind: diffuse, reflected, let through.
    /// That of microfacets is Fresnel's term at the viewer's cosine times what the facets keep, no average over them.
    pub fn colors(&self, v: Vec3) -> [Rgb; 3] {
        self.lobes().fold([Vec3::ZERO; 3], |sum, lobe| {
            let own = lobe.colors(v);
            std::array::from_fn(|k| sum[k] + own[k])
        })
    }

    /// Colours of lobes wider than a mirror's and of the others, and the chance of the wider.
    pub fn rough_and_smooth(&self, v: Vec3) -> ([Rgb; 2], f32) {
        let (mut colors, mut rough) = ([Vec3::ZERO; 2], 0.0);
        for lobe in self.lobes() {
            let color: Rgb = lobe.colors(v).into_iter().sum();
            if lobe.is_rough() {
                rough += lobe.chance;
                colors[0] += color;
            } else {
                colors[1] += color;
            }
        }
        (colors, rough)
    }
    /// Whether light from behind the surface may reach the viewer.
    pub fn transmits(&self) -> bool {
        self.lobes().any(|l| match &l.kind {
            LobeKind::Translucent | LobeKind::Hair(_) => true,
            LobeKind::Microfacet(m) => m.refracts,
            _ => false,
        })
    }

    #[inline]
    fn eval_but(&self, v: Vec3, l: Vec3, skip: usize, met: bool) -> (Rgb, f32) {
        let (mut value, mut pdf) = (Vec3::ZERO, 0.0);
        for (_, lobe) in self.lobes().enumerate().filter(|(k, _)| *k != skip) {
            let (f, p) = self.eval_lobe(lobe, v, l, met);
            value += f * lobe.weight * self.shade(lobe, l);
            pdf += p * lobe.chance;
        }
        (value, pdf / self.total)
    }

    /// Draws a direction; `u` are four numbers in 0..1. `None`: the light is lost.
    pub fn sample(&self, v: Vec3, u: [f32; 4]) -> Option<BsdfSample> {
        if self.lobes.is_empty() {
            return None;
        }
        let mut target = u[3] * self.total;
        let mut ix = self.lobes.len() - 1;
        for (k, lobe) in self.lobes().enumerate() {
            if target < lobe.chance {
                ix = k;
                break;
            }
            target -= lobe.chance;
        }
        let lobe = &self.lobes[ix];
        let s = self.sample_lobe(lobe, v, [u[0], u[1], u[2]])?;
        let (mut value, mut pdf) = (s.value * lobe.weight * self.shade(lobe, s.l), s.pdf * lobe.chance / self.total);
        if self.lobes.len() > 1 {
            let (f, p) = self.eval_but(v, s.l, ix, true);
            value += f;
            pdf += p;
        }
        Some(BsdfSample {
            l: s.l.normalize_or(self.normal),
            value,
            pdf,
            event: s.event.unwrap_or_else(|| lobe.event(s.l)),
            singular: s.singular,
            width: lobe.width(),
        })
    }
}
