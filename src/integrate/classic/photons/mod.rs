//! Photons: light that mirrors and glass cast on what stands around, shot from the lights before the picture and gathered in it.
//! Source: spec/light.md, section 9.
//!
//! `emission` says where photons start, `tracing` follows them, `map` keeps them and finds the nearest, `radius` says how far to look, and
//! `estimate` makes them light. A map does not depend on the number of threads: the rings of a pair of light and target are drawn from one
//! random stream, then followed side by side. In order (`RenderSettings::in_order`) that stream runs on from pair to pair, as POV-Ray's
//! does; else every pair has its own, and pairs run side by side too.

mod emission;
mod estimate;
mod map;
mod radius;
#[cfg(test)]
mod tests;
mod tracing;

pub(super) use emission::take_over;
pub use map::NearestPhotons;

use super::plan::{ScenePlan, interiors_at};
use super::ray::InteriorList;
use super::trace::Tracer;
use crate::compile::CompiledScene;
use crate::math::random::{SplitMix64, UniformStream};
use crate::memory::{MemoryLimit, OutOfMemory};
use crate::scene::settings::Photons;
use emission::{Emission, Ring, pairs, spacing_for};
use map::PhotonMap;
use radius::automatic_radius;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use tracing::{Deposits, PhotonTracer};

/// Most photons that are shot: below a millionth of a second each they would take a day.
const MOST_SHOT: f64 = 1e11;
/// Photons that are drawn at a time, in whole rings.
const BATCH: usize = 1 << 14;

/// The photons of a scene at rest, and how they are gathered.
#[derive(Debug)]
pub struct PhotonMaps {
    surface: PhotonMap,
    media: PhotonMap,
    radius: f64,
    media_radius: f64,
    /// Fewest photons before the radius is widened, most that are kept.
    least: u32,
    most: u32,
    expand: (f64, u32),
    /// What it took.
    pub stats: PhotonStats,
}

/// What shooting photons came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "the names say it")]
pub struct PhotonStats {
    pub shot: u64,
    pub on_surfaces: u64,
    pub in_media: u64,
    pub radius: f64,
    pub media_radius: f64,
}

/// Why photons could not be shot.
#[derive(Debug, thiserror::Error)]
pub enum PhotonError {
    /// They would not end in a day.
    #[error("the scene asks for about {expected:.1e} photons, more than {MOST_SHOT:.0e}: a larger spacing, or a count, makes fewer")]
    TooMany {
        /// About how many.
        expected: f64,
    },
    /// They take more memory than the process may use.
    #[error("{stored} photons and more do not fit: {cause}. A larger spacing, or a count, makes fewer")]
    Memory {
        /// So many were kept.
        stored: u64,
        /// What was refused.
        cause: OutOfMemory,
    },
}

/// Hears how many photons of how many are shot, from any thread.
pub type PhotonProgress<'p> = &'p (dyn Fn(u64, u64) + Sync);

impl PhotonMaps {
    /// Whether a scene that is rendered in this way shoots photons at all.
    pub fn are_asked_for(scene: &CompiledScene, plan: &ScenePlan) -> bool {
        plan.quality.volumes && scene.settings.photons.is_some() && !pairs(scene).is_empty()
    }

    /// Shoots the photons of a scene. Stops early, with what there is, once `cancel` is set.
    pub fn shoot(
        scene: &CompiledScene,
        plan: &ScenePlan,
        in_order: bool,
        progress: PhotonProgress,
        cancel: &AtomicBool,
    ) -> Result<Self, PhotonError> {
        let settings = scene.settings.photons.clone().unwrap_or_default();
        let pairs = pairs(scene);
        let spacing = if settings.count > 0 { spacing_for(&pairs, settings.count) } else { settings.spacing };
        let aimed: Vec<Emission> = pairs.iter().map(|p| Emission::new(*p, spacing, settings.jitter)).filter(Emission::is_sound).collect();
        let expected: f64 = aimed.iter().map(Emission::expected).sum();
        if expected > MOST_SHOT {
            return Err(PhotonError::TooMany { expected });
        }
        let shooting = Shooting {
            scene,
            plan,
            settings: &settings,
            in_order,
            cancel,
            expected: expected as u64,
            n_shot: AtomicU64::new(0),
            n_stored: AtomicU64::new(0),
            progress,
            memory: scene.options.memory,
        };
        let all = if in_order {
            let mut streams = (UniformStream::default(), UniformStream::default());
            aimed.iter().map(|e| shooting.pair(e, &mut streams)).collect::<Result<Vec<_>, _>>()?
        } else {
            let one = |(k, e): (usize, &Emission)| {
                let mut seeds = SplitMix64(k as u64);
                shooting.pair(e, &mut (UniformStream::seeded(&mut seeds), UniformStream::seeded(&mut seeds)))
            };
            aimed.par_iter().enumerate().with_max_len(1).map(one).collect::<Result<Vec<_>, _>>()?
        };
        let shot = all.iter().map(|(n, _)| n).sum();
        let (mut surface, mut media) = (Vec::new(), Vec::new());
        for (_, mut d) in all {
            surface.append(&mut d.surface);
            media.append(&mut d.media);
        }
        let mut maps = Self {
            surface: PhotonMap::build(surface),
            media: PhotonMap::build(media),
            radius: 0.0,
            media_radius: 0.0,
            least: settings.gather.0,
            most: settings.gather.1,
            expand: settings.expand,
            stats: PhotonStats::default(),
        };
        let [radius, factor, media_radius, media_factor] = settings.radius;
        let of = |given: f64, map: &PhotonMap, volume| if given > 0.0 { given } else { automatic_radius(map, maps.most, volume) };
        (maps.radius, maps.media_radius) =
            (factor * of(radius, &maps.surface, false), 2.0 * media_factor * of(media_radius, &maps.media, true));
        maps.stats = PhotonStats {
            shot,
            on_surfaces: maps.surface.len() as u64,
            in_media: maps.media.len() as u64,
            radius: maps.radius,
            media_radius: maps.media_radius,
        };
        Ok(maps)
    }

    /// Room for what one gathering finds.
    pub fn room(&self) -> NearestPhotons {
        NearestPhotons::new(self.most)
    }

    /// Whether there are any.
    pub fn is_empty(&self) -> bool {
        self.surface.is_empty() && self.media.is_empty()
    }
}

/// One run of shooting.
struct Shooting<'s> {
    scene: &'s CompiledScene,
    plan: &'s ScenePlan,
    settings: &'s Photons,
    in_order: bool,
    cancel: &'s AtomicBool,
    expected: u64,
    n_shot: AtomicU64,
    n_stored: AtomicU64,
    progress: PhotonProgress<'s>,
    memory: MemoryLimit,
}

impl Shooting<'_> {
    /// Shoots one pair's photons: gives their number and what they left. `streams` are those of emission and of media.
    fn pair(&self, e: &Emission, streams: &mut (UniformStream, UniformStream)) -> Result<(u64, Deposits), PhotonError> {
        let mut out = Deposits::default();
        let (mut n_shot, mut k) = (0, 0);
        let fixed = (!e.has_grid()).then(|| interiors_at(self.scene, e.pair.light.light.location));
        while !self.cancel.load(Ordering::Relaxed) {
            let mut rings: Vec<Ring> = Vec::new();
            let (mut n, mut stream) = (0, streams.0);
            while let Some(theta) = e.theta(k).filter(|_| n < BATCH) {
                let ring = e.ring(self.scene, theta, stream);
                (n, stream, k) = (n + ring.shots.len(), ring.stream, k + 1);
                rings.push(ring);
            }
            if rings.is_empty() {
                break;
            }
            for (ring, d) in rings.iter().zip(self.follow(e, &rings, fixed.as_ref(), &mut streams.1)) {
                n_shot += ring.n_counted;
                streams.0 = ring.stream;
                let stops = out.met_target && !d.met_target && e.may_stop(ring.theta, self.settings.autostop);
                out.append(d);
                if stops {
                    return Ok((n_shot, out));
                }
            }
            self.note(n as u64, &out)?;
        }
        Ok((n_shot, out))
    }

    /// Follows the photons of rings, what each ring left in its place.
    fn follow(&self, e: &Emission, rings: &[Ring], fixed: Option<&InteriorList>, media: &mut UniformStream) -> Vec<Deposits> {
        let one = |ring: &Ring, media: UniformStream| {
            let mut tracer = Tracer::new(self.scene, self.plan).until(self.cancel);
            tracer.max_level = self.settings.max_trace_level;
            tracer.adc_bailout = self.settings.adc_bailout;
            tracer.media_random = media;
            let mut p = PhotonTracer { tracer: &mut tracer, emission: e, settings: self.settings, out: Deposits::default() };
            for shot in &ring.shots {
                match fixed {
                    Some(list) => p.follow(shot, list),
                    None => p.follow(shot, &interiors_at(self.scene, shot.ray.origin)),
                }
            }
            let out = p.out;
            (out, tracer.media_random)
        };
        if self.in_order && self.settings.media.0 > 0 {
            // Media draw numbers while photons fly.
            let mut in_turn = |ring| {
                let (out, stream) = one(ring, *media);
                *media = stream;
                out
            };
            return rings.iter().map(&mut in_turn).collect();
        }
        let seeded = |ring: &Ring| one(ring, UniformStream::seeded(&mut SplitMix64(ring.theta.to_bits()))).0;
        rings.par_iter().with_max_len(1).map(seeded).collect()
    }

    /// Tells the progress, and looks whether the photons still fit.
    fn note(&self, n: u64, out: &Deposits) -> Result<(), PhotonError> {
        let n_shot = self.n_shot.fetch_add(n, Ordering::Relaxed) + n;
        (self.progress)(n_shot.min(self.expected), self.expected);
        let own = (out.surface.len() + out.media.len()) as u64;
        let stored = self.n_stored.fetch_max(own, Ordering::Relaxed).max(own);
        // Lists grow by doubling, and are joined at the end.
        let more = 2 * own * PhotonMap::PHOTON_BYTES as u64;
        self.memory.allows(more).map_err(|cause| PhotonError::Memory { stored, cause })
    }
}

impl Deposits {
    fn append(&mut self, mut o: Deposits) {
        self.surface.append(&mut o.surface);
        self.media.append(&mut o.media);
        self.met_target |= o.met_target;
    }
}
