//! Shafts of the classic integrator: what may stand between a point and an area light is looked up once for all the shadow rays between
//! them. Lists are kept short: where much stands in the way, the tree is as good.
//!
//! Measured: a list costs what six to ten shadow rays do in small scenes. Area lights of 8 x 8 points gain by it, of 4 x 4 lose; so did
//! media (the pieces between a ray and a lamp, 12 % slower) and the beams of lens samples (no difference).

use super::trace::Tracer;
use crate::accel::{BoxF, Candidates, Shaft};
use crate::math::DVec3;
use crate::savings::Saving;
use crate::scene::Light;
use crate::scene::light::{AreaLight, LightKind};

/// Most primitives of a list: each eight of them cost a ray about what a node of the tree does.
const MOST: usize = 32;
/// Fewest points of an area light that are worth a list.
const LEAST_GRID: u32 = 25;
/// Share of an edge that the points of a circular light may lie beyond its rim.
const RIM: f64 = 0.01;

/// What is known of a shadow ray before it is traced.
#[derive(Clone, Copy)]
pub(super) enum Known<'c> {
    /// Nothing.
    Nothing,
    /// Of primitives with bounds it can meet these alone.
    Among(&'c Candidates),
    /// It meets nothing up to the light.
    Open,
    /// This primitive stops it.
    Stopped(u32),
}

/// Whether an area light has points enough for a list of what stands before it.
pub fn takes_shafts(area: &AreaLight) -> bool {
    area.n1.saturating_mul(area.n2) >= LEAST_GRID
}

impl Tracer<'_> {
    /// The primitives between `point` and an area light's grid; `None` where there are too many, or skipping is off.
    pub(super) fn before_area(&mut self, light: &Light, area: &AreaLight, axes: (DVec3, DVec3), point: DVec3) -> Option<Candidates> {
        let scene = self.scene;
        if !scene.options.savings.has(Saving::Shafts) || !takes_shafts(area) {
            return None;
        }
        let bounds = scene.geometry.tree.shaft_bounds()?;
        let shaft = area_shaft(light, area, axes, point, bounds)?;
        let mut list = std::mem::take(&mut self.spare_list);
        if scene.geometry.tree.gather(&shaft, MOST, &mut list) {
            return Some(list);
        }
        self.spare_list = list;
        None
    }

    /// Takes a list back, for its memory.
    pub(super) fn done_with(&mut self, list: Option<Candidates>) {
        if let Some(list) = list {
            self.spare_list = list;
        }
    }
}

/// The pyramid from a point to an area light; beyond the scene it may end before the light. `None` for beams that have no such apex.
fn area_shaft(light: &Light, area: &AreaLight, axes: (DVec3, DVec3), point: DVec3, bounds: &BoxF) -> Option<Shaft> {
    let center = match light.kind {
        LightKind::Sun { direction, .. } => crate::kernel::light::SUN_DISTANCE * -direction,
        LightKind::Point | LightKind::Spot { .. } if !light.parallel => light.location - point,
        _ => return None,
    };
    let half = |n: u32| {
        let cells = if n > 1 { 0.5 + if area.jitter { 0.5 / f64::from(n - 1) } else { 0.0 } } else { 0.0 };
        cells + if area.circular { RIM } else { 1e-9 }
    };
    let (a, b) = (axes.0 * half(area.n1), axes.1 * half(area.n2));
    let b_box = bounds.to_bounds();
    let reach = (b_box.max - point).abs().max((b_box.min - point).abs()).length();
    let nearest = center.length() - (a.length() + b.length());
    let share = if nearest > reach { reach / nearest } else { 1.0 };
    let to = [center - a - b, center + a - b, center + a + b, center - a + b].map(|v| share * v);
    let mut points = [point; 5];
    let mut normals = [DVec3::ZERO; 7];
    for k in 0..4 {
        points[k + 1] = point + to[k];
        normals[k] = to[k].cross(to[(k + 1) % 4]);
    }
    for (k, axis) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
        normals[4 + k] = center.cross(axis);
    }
    Some(Shaft::around(&points, &normals, bounds))
}
