//! Patterns: what gives a number at a point, with everything that bends the point first.
//! Source of all formulas: spec/textures.md, sections 1 to 4.

use super::{Function, ImageMap, Object, Pigment};
use crate::math::{DVec3, Transform};
use std::sync::Arc;

/// Noise displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turbulence {
    /// By axis.
    pub amount: DVec3,
    /// 1..=10.
    pub octaves: u32,
    /// Scale of amplitude an octave; rounded to 32 bits as POV-Ray keeps it.
    pub omega: f32,
    /// Scale of frequency an octave; rounded to 32 bits.
    pub lambda: f32,
}

impl Default for Turbulence {
    fn default() -> Self {
        Self { amount: DVec3::ZERO, octaves: 6, omega: 0.5, lambda: 2.0 }
    }
}

/// Shape of the map lookup's argument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wave {
    /// As it is.
    Ramp,
    /// Up and down.
    Triangle,
    /// Sine.
    Sine,
    /// Half sines.
    Scallop,
    /// Smoothstep.
    Cubic,
    /// Power.
    Poly(f32),
}

/// One bend of the point, undone from the last written to the first.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names of the fields say it")]
pub enum Warp {
    /// Pattern space to the outer space.
    Transform(Transform),
    /// Tiles along one axis (0, 1, 2); `width` may be negative; `flip` mirrors odd tiles.
    Repeat { axis: u8, width: f64, offset: DVec3, flip: [bool; 3] },
    /// Pulls points near a centre.
    BlackHole { center: DVec3, radius: f64, strength: f64, falloff: f64, inverse: bool, repeat: Option<DVec3>, turbulence: DVec3 },
    /// Displacement by noise.
    Turbulence(Turbulence),
    /// Around an axis.
    Cylindrical { orientation: DVec3, dist_exp: f64 },
    /// Around a centre.
    Spherical { orientation: DVec3, dist_exp: f64 },
    /// Around a ring.
    Toroidal { orientation: DVec3, dist_exp: f64, major_radius: f64 },
    /// Onto a plane.
    Planar { orientation: DVec3, distance: f64 },
    /// Cube map.
    Cubic,
}

/// Complex-plane fractals.
#[derive(Clone, Debug, PartialEq)]
pub struct FractalPattern {
    /// 0 for Mandelbrot and Julia, 1 or 2 for the magnet kinds.
    pub magnet: u8,
    /// The Julia constant, `None` for the Mandelbrot kinds.
    pub julia: Option<(f64, f64)>,
    /// Most iterations.
    pub iterations: u32,
    /// 2..=33.
    pub exponent: u32,
    /// Colouring outside: type 0..=8, factor.
    pub exterior: (u8, f64),
    /// Colouring inside: type 0..=6, factor.
    pub interior: (u8, f64),
}

/// A density grid of a df3 file, `[z][y][x]`, values 0..=1.
#[derive(Clone, Debug, PartialEq)]
pub struct DensityGrid {
    /// Cells along x, y, z.
    pub size: [u32; 3],
    /// Values.
    pub values: Vec<f32>,
}

/// What gives the number.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "the names are POV-Ray's keywords; spec/textures.md section 2 defines each")]
pub enum PatternKind {
    /// No pattern: a plain colour.
    Plain,
    Agate {
        turb: f32,
    },
    Aoi,
    Average,
    Boxed,
    Bozo,
    Brick {
        size: DVec3,
        mortar: f32,
    },
    Bumps,
    Cells,
    Checker,
    Crackle {
        form: DVec3,
        metric: f64,
        offset: f64,
        solid: bool,
    },
    Cubic,
    Cylindrical,
    /// `interpolate` is 0, 1 or 2.
    DensityFile {
        grid: Arc<DensityGrid>,
        interpolate: u8,
    },
    Dents,
    Facets {
        coords: Option<f64>,
        size: f64,
        metric: f64,
    },
    Fractal(FractalPattern),
    Function(Arc<Function>),
    /// Direction as written; not unit.
    Gradient(DVec3),
    Granite,
    Hexagon,
    Image(Arc<ImageMap>),
    Leopard,
    Marble,
    Object(Arc<Object>),
    Onion,
    Pavement {
        sides: u8,
        tiles: u8,
        pattern: u8,
        interior: u8,
        exterior: u8,
        form: u8,
    },
    Pigment(Arc<Pigment>),
    Planar,
    Quilted {
        control0: f32,
        control1: f32,
    },
    Radial,
    Ripples,
    /// `direction` is the slope vector, or the point when `point_at`; lengths are weights.
    Slope {
        direction: DVec3,
        point_at: bool,
        low: f64,
        high: f64,
        altitude: Option<(DVec3, f64, f64)>,
    },
    Spherical,
    Spiral1 {
        arms: i32,
    },
    Spiral2 {
        arms: i32,
    },
    Spotted,
    Square,
    Tiling(u8),
    Triangular,
    Waves,
    Wood,
    Wrinkles,
}

/// A pattern with its modifiers.
#[derive(Clone, Debug)]
pub struct Pattern {
    /// What gives the number.
    pub kind: PatternKind,
    /// In the order written; undone from the last to the first.
    pub warps: Vec<Warp>,
    /// The classic `turbulence`, always nearest to the pattern.
    pub turbulence: Option<Turbulence>,
    /// Multiplies the value; 0 means "leave the value alone".
    pub frequency: f32,
    /// Added to the value.
    pub phase: f32,
    /// Shapes the value.
    pub wave: Wave,
    /// Overrides the global noise generator, 1..=3.
    pub noise_generator: Option<u8>,
}

impl Default for Pattern {
    fn default() -> Self {
        Self {
            kind: PatternKind::Plain,
            warps: Vec::new(),
            turbulence: None,
            frequency: 1.0,
            phase: 0.0,
            wave: Wave::Ramp,
            noise_generator: None,
        }
    }
}

impl Pattern {
    /// Appends a transform; consecutive transforms merge.
    pub fn transform(&mut self, t: &Transform) {
        if let Some(Warp::Transform(last)) = self.warps.last_mut() {
            *last = last.then(t);
        } else {
            self.warps.push(Warp::Transform(*t));
        }
    }
}
