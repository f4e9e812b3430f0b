//! What arrives of a light at a point: shadow rays through clear things, grids of area lights. Source: spec/light.md, section 6.

use super::lights::{area_place, is_dark};
use super::photons;
use super::ray::InteriorList;
use super::refract::fade_factor;
use super::shafts::Known;
use super::texturing as cover;
use super::trace::Tracer;
use crate::accel::Candidates;
use crate::compile::texture::TextureNode;
use crate::compile::{CompiledScene, NONE};
use crate::kernel::atmosphere::fog_effect;
use crate::kernel::light::{LightRay, area_axes, area_offset, light_ray};
use crate::kernel::traverse::{
    Among, ClearPrims, SHADOW_TOLERANCE, ShadowHints, ShadowHit, intersect_clear, intersect_object, intersect_shadow_noting,
};
use crate::kernel::{PatternPoint, SurfaceHit};
use crate::math::{DVec3, Ray, Rgb, Rgbft, Vec3};
use crate::savings::Saving;
use crate::scene::light::AreaLight;

/// Most clear surfaces that one shadow ray passes.
const MAX_CLEAR_SURFACES: usize = 10_000;

/// Open ways to an area light after which the rest of its grid gets a list of what stands before it.
const WALKS_BEFORE_LIST: u32 = 4;

impl Tracer<'_> {
    /// `color` less what stands between `point` and the light along `way`.
    pub(super) fn unshadowed(
        &mut self,
        light_ix: u32,
        around: &InteriorList,
        point: DVec3,
        way: &LightRay,
        color: Rgb,
        known: Known,
    ) -> Rgb {
        let scene = self.scene;
        let compiled = &scene.lights[light_ix as usize];
        let mut ray = Ray::new(point, way.dir);
        let mut left = way.distance;
        if compiled.projected_through != NONE {
            match intersect_object(scene, compiled.projected_through, &ray, SHADOW_TOLERANCE, left) {
                Some(hit) => left = hit.t,
                None => return Vec3::ZERO,
            }
        }
        if compiled.light.shadowless {
            return color;
        }
        let slot = usize::from(self.level > 1);
        let mut color = color;
        let mut interiors: Option<InteriorList> = None;
        let mut noted = ClearPrims::default();
        for nth in 0..MAX_CLEAR_SURFACES {
            if left <= 2.0 * SHADOW_TOLERANCE {
                break;
            }
            let last = if scene.options.savings.has(Saving::Blockers) { self.blockers[light_ix as usize][slot] } else { u32::MAX };
            let onward =
                |among: Among, noted: &mut ClearPrims| onward_to_light(scene, &ray, left, nth == 0, &ShadowHints { last, among }, noted);
            let hit = match known {
                Known::Open => ShadowHit::None,
                Known::Stopped(prim_ix) => ShadowHit::Opaque { prim_ix },
                Known::Among(list) => onward(Among::Candidates(list), &mut noted),
                Known::Nothing => onward(Among::All, &mut noted),
            };
            match hit {
                ShadowHit::None => {
                    // The last blocker stands in the way no more: asking it first would cost every ray of the lit part. In half shadows of
                    // area lights it will soon do so again.
                    if compiled.light.area.is_none() {
                        self.blockers[light_ix as usize][slot] = u32::MAX;
                    }
                    break;
                }
                ShadowHit::Opaque { prim_ix } => {
                    self.blockers[light_ix as usize][slot] = prim_ix;
                    return Vec3::ZERO;
                }
                ShadowHit::Transparent(hit) => {
                    if self.photons_replace && photons::take_over(scene.geometry.prims[hit.prim_ix as usize].flags, compiled) {
                        return Vec3::ZERO;
                    }
                    let list = interiors.get_or_insert_with(|| around.clone());
                    color *= self.surface_filter(&ray, &hit, list);
                    color = self.shadow_air(light_ix, &ray, hit.t, list, color, Some(&hit));
                    if is_dark(color) {
                        return Vec3::ZERO;
                    }
                    list.toggle(scene, scene.geometry.prims[hit.prim_ix as usize].interior_ix);
                    ray.origin = hit.point;
                    left -= hit.t;
                }
            }
        }
        if left > SHADOW_TOLERANCE {
            let list = interiors.as_ref().unwrap_or(around);
            color = self.shadow_air(light_ix, &ray, left, list, color, None);
        }
        color
    }

    /// What surfaces leave of light that comes along `ray` from `distance` away; the air is not looked at.
    pub(super) fn clear_way(&self, around: &InteriorList, mut ray: Ray, distance: f64) -> Rgb {
        let (mut color, mut left) = (Vec3::ONE, distance);
        let mut list = around.clone();
        let mut noted = ClearPrims::default();
        for nth in 0..MAX_CLEAR_SURFACES {
            if left <= 2.0 * SHADOW_TOLERANCE {
                break;
            }
            match onward_to_light(self.scene, &ray, left, nth == 0, &ShadowHints::NONE, &mut noted) {
                ShadowHit::None => break,
                ShadowHit::Opaque { .. } => return Vec3::ZERO,
                ShadowHit::Transparent(hit) => {
                    color *= self.surface_filter(&ray, &hit, &list);
                    list.toggle(self.scene, self.scene.geometry.prims[hit.prim_ix as usize].interior_ix);
                    ray.origin = hit.point;
                    left -= hit.t;
                    if is_dark(color) {
                        break;
                    }
                }
            }
        }
        color
    }

    /// Whether shadow rays lose nothing on their way through the air.
    #[inline]
    pub(super) fn is_air_clear(&self) -> bool {
        !self.plan.quality.volumes || !self.plan.has_media && self.scene.fogs.is_empty()
    }

    /// What the air and the media on `0..depth` of a shadow ray leave of `color`; `hit` ends the piece unless it ends at the light.
    fn shadow_air(&mut self, light_ix: u32, ray: &Ray, depth: f64, around: &InteriorList, color: Rgb, hit: Option<&SurfaceHit>) -> Rgb {
        if self.is_air_clear() {
            return color;
        }
        let scene = self.scene;
        let light = &scene.lights[light_ix as usize].light;
        let mut color = color;
        if self.plan.has_media {
            color = self.shadow_media(light, ray, depth, around, color, hit.is_some());
        }
        if !scene.fogs.is_empty() && light.media_attenuation && light.media_interaction && around.is_hollow() {
            color *= fog_effect(&scene.fogs, ray, depth, |fog, p| cover::fog_turbulence(scene, fog, p)).factor;
        }
        color
    }

    /// What a clear surface lets through, with the fading of the way inside it.
    fn surface_filter(&self, ray: &Ray, hit: &SurfaceHit, around: &InteriorList) -> Rgb {
        let scene = self.scene;
        let prim = &scene.geometry.prims[hit.prim_ix as usize];
        let from_inside = hit.normal.dot(ray.dir) > 0.0;
        let normal = if from_inside { -hit.normal } else { hit.normal };
        let interior = &scene.interiors[prim.interior_ix as usize];
        let seen = std::cell::Cell::new(normal);
        let through = |c: cover::Cover| {
            let p = cover::pattern_point(scene, hit, prim, &c, normal, ray.dir);
            self.texture_filter(c.texture, hit, &p, &cover::Space::of_cover(&c, &seen), ray.dir, interior.caustics)
        };
        let mut sum = match cover::sole_cover_at(scene, hit, from_inside, self.adc_bailout) {
            Some(c) => through(c),
            None => {
                let covers = cover::covers_at(scene, hit, from_inside, self.adc_bailout);
                covers.iter().fold(Vec3::ZERO, |sum, (c, weight)| sum + weight * through(c))
            }
        };
        if interior.fade_power > 0.0 && around.position(prim.interior_ix).is_some() {
            sum *= fade_factor(interior, hit.t);
        }
        sum
    }

    fn texture_filter(&self, texture: u32, hit: &SurfaceHit, p: &PatternPoint, space: &cover::Space, dir: DVec3, caustics: f64) -> Rgb {
        let scene = self.scene;
        match &scene.textures.textures[texture as usize] {
            TextureNode::Layers { start, len } => {
                let mut product = Vec3::ONE;
                for k in (*start..*start + *len).rev() {
                    let layer = scene.textures.layers[k as usize];
                    let mut normal = p.normal;
                    if self.plan.quality.normals && layer.normal != NONE {
                        normal = cover::perturb(scene, layer.normal, normal, p, space);
                    }
                    let color = cover::layer_color(scene, layer.pigment, p, space.seen.get(), self.plan.quality.quick_colors)
                        .unwrap_or(Rgbft::CLEAR);
                    product *= color.transmittance();
                    if caustics != 0.0 {
                        product *= (1.0 + dir.dot(normal).abs().powf(caustics)) as f32;
                    }
                }
                product
            }
            TextureNode::Principled(ix) => self.principled_filter(*ix, hit),
            node => {
                let parts = cover::blend(scene, node, p, space);
                let inner = cover::Space { parent: Some(space), step: parts.step, seen: space.seen };
                (0..parts.entries.len()).fold(Vec3::ZERO, |sum, k| {
                    let (texture, share) = parts.entries.get(k);
                    sum + share * self.texture_filter(texture, hit, &parts.point, &inner, dir, caustics)
                })
            }
        }
    }

    /// The mean over an area light's grid, by quadrants, of what arrives from its points.
    pub(super) fn through_area(
        &mut self,
        light_ix: u32,
        area: &AreaLight,
        around: &InteriorList,
        point: DVec3,
        way: &LightRay,
        color: Rgb,
    ) -> Rgb {
        let mut points = std::mem::take(&mut self.area_points);
        points.clear();
        points.resize(area.n1 as usize * area.n2 as usize, None);
        let axes = area_axes(area, way.dir);
        let mut grid = AreaGrid { light_ix, area, axes, around, point, color, points, n_open: 0, among: None };
        let mean = match self.area_points_together(&mut grid) {
            Some(mean) => mean,
            None => self.area_part(&mut grid, [0, 0, area.n1.max(1) - 1, area.n2.max(1) - 1], 0),
        };
        self.area_points = grid.points;
        self.done_with(grid.among);
        mean
    }

    fn area_part(&mut self, grid: &mut AreaGrid, [u1, v1, u2, v2]: [u32; 4], level: u32) -> Rgb {
        let c = corners([u1, v1, u2, v2]).map(|[u, v]| self.area_point(grid, u, v));
        if u2 - u1 > 1 || v2 - v1 > 1 {
            let differ = |a: usize, b: usize| (c[a] - c[b]).abs().element_sum() > 0.1;
            if level < grid.area.adaptive || differ(0, 1) || differ(1, 3) || differ(3, 2) || differ(2, 0) {
                let parts = quarters([u1, v1, u2, v2]);
                let (mut sum, mut means) = (Vec3::ZERO, [Vec3::ZERO; 4]);
                for k in 0..4 {
                    // A single row or column has each half twice: asked twice each, long ones would take 4^n steps instead of 2^n.
                    means[k] = match parts[..k].iter().position(|p| *p == parts[k]) {
                        Some(same) => means[same],
                        None => self.area_part(grid, parts[k], level + 1),
                    };
                    sum += means[k];
                }
                return 0.25 * sum;
            }
        }
        0.25 * (c[0] + c[1] + c[2] + c[3])
    }

    fn area_point(&mut self, grid: &mut AreaGrid, u: u32, v: u32) -> Rgb {
        let place = (u * grid.area.n2 + v) as usize;
        if let Some(c) = grid.points[place] {
            return c;
        }
        if self.is_stopped() {
            return Vec3::ZERO;
        }
        let (ju, jv) = (area_place(&mut self.random, u, grid.area.jitter), area_place(&mut self.random, v, grid.area.jitter));
        let offset = area_offset(grid.area, grid.axes, ju, jv);
        let way = light_ray(&self.scene.lights[grid.light_ix as usize].light, grid.point, offset);
        let known = grid.among.as_ref().map_or(Known::Nothing, Known::Among);
        let c = self.unshadowed(grid.light_ix, grid.around, grid.point, &way, grid.color, known);
        if !is_dark(c) {
            grid.n_open += 1;
            // Few rays walk far: the four corners, when no more are wanted, and what the last blocker does not stop.
            if grid.n_open == WALKS_BEFORE_LIST {
                grid.among = self.before_area(&self.scene.lights[grid.light_ix as usize].light, grid.area, grid.axes, grid.point);
            }
        }
        grid.points[place] = Some(c);
        c
    }
}

/// What a shadow ray meets next. The first piece of it looks through the scene, which says what the rest may meet.
fn onward_to_light(scene: &CompiledScene, ray: &Ray, left: f64, is_first: bool, hints: &ShadowHints, noted: &mut ClearPrims) -> ShadowHit {
    let (t_min, t_max) = (SHADOW_TOLERANCE, left - SHADOW_TOLERANCE);
    match noted.all() {
        Some(prims) if !is_first => intersect_clear(scene, ray, t_min, t_max, prims).map_or(ShadowHit::None, ShadowHit::Transparent),
        _ => {
            noted.clear();
            intersect_shadow_noting(scene, ray, t_min, t_max, hints, noted)
        }
    }
}

/// Corners of a part of a grid, in the order in which they are asked.
pub(super) fn corners([u1, v1, u2, v2]: [u32; 4]) -> [[u32; 2]; 4] {
    [[u1, v1], [u2, v1], [u1, v2], [u2, v2]]
}

/// The quarters that a part of a grid is cut into; they share its middle lines where those lie on points.
pub(super) fn quarters([u1, v1, u2, v2]: [u32; 4]) -> [[u32; 4]; 4] {
    let (ul, uh, vl, vh) = ((u1 + u2) / 2, (u1 + u2).div_ceil(2), (v1 + v2) / 2, (v1 + v2).div_ceil(2));
    [[u1, v1, ul, vl], [uh, v1, u2, vl], [u1, vh, ul, v2], [uh, vh, u2, v2]]
}

/// One shadow test of an area light.
pub(super) struct AreaGrid<'g> {
    pub light_ix: u32,
    pub area: &'g AreaLight,
    pub axes: (DVec3, DVec3),
    pub around: &'g InteriorList,
    pub point: DVec3,
    pub color: Rgb,
    /// By grid point: what arrived from it.
    pub points: Vec<Option<Rgb>>,
    /// Points that light came from.
    n_open: u32,
    /// What may stand in the way, once it was worth asking.
    among: Option<Candidates>,
}
