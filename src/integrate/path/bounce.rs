//! Counting bounces, visibility by ray kind, Russian roulette: as Cycles does.

use crate::compile::geometry::prim_flags;
use crate::kernel::bsdf::Event;
use crate::math::Rgb;
use crate::scene::shader::RaySort;
use crate::scene::{PathSettings, Visibility};

/// What made a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    Camera,
    Diffuse,
    Glossy,
    Transmission,
    Volume,
}

impl RayKind {
    /// What a surface knows of such a ray; `sharp`: it left a perfect mirror or clear glass.
    pub fn sort(self, sharp: bool) -> RaySort {
        match self {
            Self::Camera => RaySort::Camera,
            Self::Diffuse => RaySort::Diffuse,
            Self::Glossy if sharp => RaySort::SharpGlossy,
            Self::Glossy => RaySort::Glossy,
            Self::Transmission if sharp => RaySort::SharpTransmission,
            Self::Transmission => RaySort::Transmission,
            Self::Volume => RaySort::Volume,
        }
    }

    /// The kind as a set.
    pub fn visibility(self) -> Visibility {
        match self {
            Self::Camera => Visibility::CAMERA,
            Self::Diffuse => Visibility::DIFFUSE,
            Self::Glossy => Visibility::GLOSSY,
            Self::Transmission => Visibility::TRANSMISSION,
            Self::Volume => Visibility::VOLUME,
        }
    }

    /// Primitives that such rays do not see.
    pub fn skip_flags(self) -> u32 {
        match self {
            Self::Camera => prim_flags::NO_IMAGE,
            Self::Diffuse => prim_flags::NO_DIFFUSE | prim_flags::NO_RADIOSITY,
            Self::Glossy => prim_flags::NO_GLOSSY | prim_flags::NO_REFLECTION,
            Self::Transmission => prim_flags::NO_TRANSMISSION,
            Self::Volume => prim_flags::NO_VOLUME,
        }
    }
}

/// Bounces so far.
#[derive(Clone, Copy, Debug)]
pub struct Bounces {
    /// Of all kinds but transparent ones.
    pub total: u32,
    diffuse: u32,
    glossy: u32,
    transmission: u32,
    volume: u32,
    /// Transparent surfaces gone through.
    pub transparent: u32,
    /// What made the ray.
    pub kind: RayKind,
    /// The last event was going straight on.
    just_passed: bool,
    /// A limit is reached: what the ray meets may shine, but scatters no more.
    pub is_last: bool,
    /// The limit of transparent surfaces is reached.
    is_blocked: bool,
}

impl Bounces {
    /// A ray from the camera.
    pub fn camera() -> Self {
        Self {
            total: 0,
            diffuse: 0,
            glossy: 0,
            transmission: 0,
            volume: 0,
            transparent: 0,
            kind: RayKind::Camera,
            just_passed: false,
            is_last: false,
            is_blocked: false,
        }
    }

    /// Whether a diffuse bounce lies between here and the camera.
    pub fn has_been_diffuse(&self) -> bool {
        self.diffuse > 0
    }

    /// After a bounce off a surface.
    pub fn scattered(&mut self, event: Event, limits: &PathSettings) {
        self.total += 1;
        self.just_passed = false;
        let mut last = self.total > limits.max_bounces;
        match event {
            Event::Diffuse => {
                self.kind = RayKind::Diffuse;
                self.diffuse += 1;
                last |= self.diffuse > limits.diffuse_bounces;
            }
            Event::Glossy => {
                self.kind = RayKind::Glossy;
                self.glossy += 1;
                last |= self.glossy > limits.glossy_bounces;
            }
            Event::Transmission => {
                self.kind = RayKind::Transmission;
                self.transmission += 1;
                last |= self.transmission > limits.transmission_bounces;
            }
        }
        self.is_last |= last;
    }

    /// After scattering in a volume.
    pub fn scattered_in_volume(&mut self, limits: &PathSettings) {
        self.total += 1;
        self.volume += 1;
        self.just_passed = false;
        self.kind = RayKind::Volume;
        self.is_last |= self.total > limits.max_bounces || self.volume > limits.volume_bounces;
    }

    /// After going straight on through a transparent surface.
    pub fn passed(&mut self, limits: &PathSettings) {
        self.transparent += 1;
        self.just_passed = true;
        self.is_blocked |= self.transparent > limits.transparent_bounces;
    }

    /// Chance to go on at the next surface; 0 ends the path there after its own light.
    pub fn survival(&self, throughput: Rgb, limits: &PathSettings) -> f32 {
        if self.is_blocked {
            return 0.0;
        }
        let young = if self.just_passed {
            self.transparent <= limits.min_transparent_bounces + 1
        } else {
            self.total <= limits.min_light_bounces + 1
        };
        if young { 1.0 } else { throughput.abs().max_element().sqrt().min(1.0) }
    }
}
