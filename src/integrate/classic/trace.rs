//! One ray: nearest hit, shading or sky, and the air in between. Source: spec/light.md, section 2.

use super::media::MediaScratch;
use super::photons::NearestPhotons;
use super::plan::ScenePlan;
use super::radiosity::RadiosityState;
use super::ray::{Seen, TraceRay};
use super::subsurface::SubsurfaceState;
use crate::accel::{Candidates, Packet};
use crate::compile::CompiledScene;
use crate::compile::geometry::prim_flags;
use crate::integrate::antialias::Block;
use crate::kernel::atmosphere::BACKGROUND_DEPTH;
use crate::kernel::traverse::{MIN_DEPTH, intersect};
use crate::math::Rgb;
use crate::math::random::{GrainStream, SplitMix64, UniformStream};
use std::sync::atomic::{AtomicBool, Ordering};

/// Rays inside rays: bounds the stack whatever the scene (transmitted rays of equal index count no level).
pub(super) const MAX_RECURSION: u32 = 1200;

/// Traces rays one after another.
pub struct Tracer<'a> {
    pub(super) scene: &'a CompiledScene,
    pub(super) plan: &'a ScenePlan,
    /// Counted rays above the current one.
    pub(super) level: u32,
    pub(super) recursion: u32,
    pub(super) max_level: u32,
    pub(super) adc_bailout: f64,
    /// Jitter of area lights and rainbows.
    pub(super) random: UniformStream,
    /// Jitter of media.
    pub(super) media_random: UniformStream,
    pub(super) grain: GrainStream,
    /// By light: the last opaque blocker of camera rays' hits, and of deeper ones.
    pub(super) blockers: Vec<[u32; 2]>,
    /// Filtered colours of global lights at the hits being shaded, a run for each hit.
    pub(super) lit: Vec<Option<Rgb>>,
    /// Filtered colours of an area light's points.
    pub(super) area_points: Vec<Option<Rgb>>,
    /// Rays to an area light's points.
    pub(super) area_packet: Box<Packet>,
    /// A list of primitives that nobody uses.
    pub(super) spare_list: Candidates,
    /// For view rays, and for the shadow rays inside them.
    pub(super) media_scratch: [Option<Box<MediaScratch>>; 2],
    /// Photons near a hit.
    pub(super) near_photons: NearestPhotons,
    /// Photons take the place of light that comes straight through their targets.
    pub(super) photons_replace: bool,
    pub(super) subsurface: SubsurfaceState,
    /// Present while radiosity is on.
    pub radiosity: Option<RadiosityState>,
    /// Once set, all that follows is black: a single pixel may take hours.
    pub(super) cancel: Option<&'a AtomicBool>,
}

impl<'a> Tracer<'a> {
    /// A tracer at the start of its random streams.
    pub fn new(scene: &'a CompiledScene, plan: &'a ScenePlan) -> Self {
        Self {
            scene,
            plan,
            level: 0,
            recursion: 0,
            max_level: scene.settings.max_trace_level.clamp(1, 256),
            adc_bailout: scene.settings.adc_bailout,
            random: UniformStream::default(),
            media_random: UniformStream::default(),
            grain: GrainStream::default(),
            blockers: vec![[u32::MAX; 2]; scene.lights.len()],
            lit: Vec::new(),
            area_points: Vec::new(),
            area_packet: Box::default(),
            spare_list: Candidates::default(),
            media_scratch: Default::default(),
            near_photons: plan.photons.as_ref().map(|m| m.room()).unwrap_or_default(),
            photons_replace: false,
            subsurface: SubsurfaceState::default(),
            radiosity: None,
            cancel: None,
        }
    }

    /// The tracer with a switch that makes the rest of its picture black, and quick.
    #[must_use]
    pub fn until(self, cancel: &'a AtomicBool) -> Self {
        Self { cancel: Some(cancel), ..self }
    }

    /// The tracer with random streams, and radiosity's, that are the block's own in this pass: what it draws depends neither on the
    /// blocks before nor on the thread.
    #[must_use]
    pub fn in_block(mut self, [x0, y0, ..]: Block, pass: u32, radiosity: Option<&RadiosityState>) -> Self {
        let mut seeds = SplitMix64(u64::from(pass) << 48 ^ u64::from(y0) << 24 ^ u64::from(x0));
        self.random = UniformStream::seeded(&mut seeds);
        self.media_random = UniformStream::seeded(&mut seeds);
        self.grain = GrainStream::seeded(&mut seeds);
        self.radiosity = radiosity.map(|r| r.in_block(&mut seeds));
        self.subsurface = SubsurfaceState::seeded(&mut seeds);
        self
    }

    /// Whether nothing of the picture is wanted any more.
    #[inline]
    pub(super) fn is_stopped(&self) -> bool {
        self.cancel.is_some_and(|c| c.load(Ordering::Relaxed))
    }

    /// What `r` sees. `weight` only decides cut-offs; a `continued` ray counts no level.
    pub(super) fn trace(&mut self, r: &TraceRay, weight: f64, continued: bool) -> Seen {
        if self.level >= self.max_level || weight < self.adc_bailout || self.recursion >= MAX_RECURSION {
            return Seen::BLACK;
        }
        if self.is_stopped() {
            return Seen::BLACK;
        }
        let counted = u32::from(!continued);
        self.level += counted;
        self.recursion += 1;
        let mut skip = if r.reflected { prim_flags::NO_REFLECTION } else { prim_flags::NO_IMAGE };
        if r.gathers {
            skip |= prim_flags::NO_RADIOSITY;
        }
        let hit = intersect(self.scene, &r.ray, MIN_DEPTH, r.max_depth, skip);
        // By reference: a copy of numbers just stored one by one waits for them.
        let (mut seen, depth) = match &hit {
            Some(hit) => {
                let (rgb, transmit) = self.shade(r, hit, weight);
                (Seen { rgb, transmit, depth: hit.t }, hit.t)
            }
            None => (self.sky(r), BACKGROUND_DEPTH),
        };
        if self.sees_volumes(r) {
            self.air(r, depth, hit.as_ref(), &mut seen);
        }
        self.level -= counted;
        self.recursion -= 1;
        seen
    }
}
