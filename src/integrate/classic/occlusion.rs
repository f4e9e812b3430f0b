//! What may stand between a small cell of space and a lamp, looked up once for all the shadow rays from there. Most cells have nothing in the
//! way, or one thing: their rays walk no tree.
//!
//! Cells grow with the distance from the camera, so that one covers a few pixels wherever it lies; they stand in a table that forgets. A list holds all
//! that a ray from the cell can meet, so pictures stay the same. Source: Woo and Amanatides 1990, "Voxel occlusion testing".

use super::area_packet::takes_cells;
use crate::accel::{Candidates, Shaft};
use crate::compile::geometry::{Geometry, Prim, PrimKind, prim_flags};
use crate::compile::{CompiledLight, CompiledScene, NONE};
use crate::kernel::light::SUN_DISTANCE;
use crate::math::{Bounds, DVec3};
use crate::scene::Light;
use crate::scene::light::{AreaLight, LightKind};

/// Most primitives of a list: where more stand in the way, the tree is as good.
const MOST: usize = 6;
/// Rays that a cell has seen when it gets its list.
const ENOUGH: u16 = 4;
/// Places of the table, a power of two.
const N_CELLS: usize = 1024;
/// Bits of a cell's number along an axis.
const AXIS_BITS: u32 = 12;
/// How shadow rays that start together lie; the sides of cells are 2 to this times those for surfaces.
#[derive(Clone, Copy, Debug)]
#[repr(u64)]
pub(super) enum Spread {
    /// On a surface that is seen.
    Surface = 0,
    /// All along a ray.
    Medium = 1,
}

/// Sides of cells, in pixels at their distance, are between this and half of it.
const SIDE: f64 = 24.0;

/// Where shadow rays to a lamp end.
#[derive(Clone, Copy, Debug)]
pub struct LampPlace(End);

#[derive(Clone, Copy, Debug)]
enum End {
    /// In this box.
    Within(Bounds),
    /// They run in this direction, as far as the scene goes.
    Toward(DVec3),
}

impl LampPlace {
    /// Of a lamp whose shadow rays are looked up; `None` for lamps that throw no shadow or look at other things first.
    pub fn of(lamp: &CompiledLight) -> Option<Self> {
        let light = &lamp.light;
        if light.shadowless || lamp.projected_through != NONE {
            return None;
        }
        let is_point = !light.parallel && matches!(light.kind, LightKind::Point | LightKind::Spot { .. });
        let place = match light.kind {
            _ if light.area.as_ref().is_some_and(|a| !is_point || !takes_cells(a)) => return None,
            LightKind::Sun { direction, .. } => End::Toward((SUN_DISTANCE * -direction).try_normalize()?),
            _ if is_point => {
                let reach = light.area.as_ref().map_or(DVec3::ZERO, grid_reach);
                End::Within(Bounds { min: light.location - reach, max: light.location + reach })
            }
            _ => End::Toward(beam(light)?),
        };
        let is_finite = match place {
            End::Within(b) => b.min.is_finite() && b.max.is_finite(),
            End::Toward(d) => d.is_finite(),
        };
        is_finite.then_some(Self(place))
    }

    /// A box around the lamp, if it has a place.
    pub fn bounds(&self) -> Option<&Bounds> {
        if let End::Within(b) = &self.0 { Some(b) } else { None }
    }
}

/// How far the points of a grid may lie from its middle, by axis.
fn grid_reach(area: &AreaLight) -> DVec3 {
    // Jitter moves a point by half a cell; circular lights shift theirs by a thousandth of an axis.
    let half = |n: u32| 0.502 + if area.jitter && n > 1 { 0.5 / f64::from(n - 1) } else { 0.0 };
    let (a, b) = (half(area.n1), half(area.n2));
    if area.orient { DVec3::splat((a + b) * area.axis1.length()) } else { a * area.axis1.abs() + b * area.axis2.abs() }
}

/// What is known of all the ways from a point to a lamp.
#[derive(Clone, Copy)]
pub(super) struct FewBetween {
    prims: [u32; MOST],
    /// Length of the list; more than it has room for where there is none.
    n: usize,
    /// The primitive of the point, where no way meets it again, or `u32::MAX`.
    pub left: u32,
}

impl Default for FewBetween {
    fn default() -> Self {
        Self { prims: [0; MOST], n: usize::MAX, left: u32::MAX }
    }
}

impl FewBetween {
    /// These at most.
    pub fn of(list: &[u32]) -> Self {
        let mut out = Self { n: list.len(), ..Self::default() };
        out.prims[..list.len()].copy_from_slice(list);
        out
    }

    /// Those that stand between, if they are known.
    #[inline]
    pub fn list(&self) -> Option<&[u32]> {
        self.prims.get(..self.n)
    }

    /// The same where they cost a packet of rays less than a walk through the tree.
    pub fn cheap_list(&self, g: &Geometry) -> Option<&[u32]> {
        self.list().filter(|list| list.len() <= 4 && list.iter().all(|p| g.prims[*p as usize].is_cheap()))
    }

    /// Whether nothing stands between.
    #[inline]
    pub fn are_none(&self) -> bool {
        self.list().is_some_and(|l| l.iter().all(|p| *p == self.left))
    }
}

/// Where parallel light comes from.
fn beam(light: &Light) -> Option<DVec3> {
    (light.location - light.point_at).try_normalize()
}

/// What is known of the shadow rays from a cell to a lamp.
#[derive(Clone, Copy)]
struct Cell {
    /// Cell and lamp; 0 for nothing.
    key: u64,
    n_asked: u16,
    /// Length of the list; `CROWDED` where there is none.
    n: u16,
    prims: [u32; MOST],
}

const CROWDED: u16 = u16::MAX;

impl Cell {
    const EMPTY: Self = Self { key: 0, n_asked: 0, n: CROWDED, prims: [0; MOST] };
}

/// The cells that rays came from last.
pub(super) struct OcclusionCells {
    cells: Vec<Cell>,
    eye: DVec3,
    /// Side of a cell by the distance.
    scale: f64,
    found: Candidates,
}

impl OcclusionCells {
    /// For pictures of a scene whose pixels are `pixel` wide at distance 1.
    pub fn new(scene: &CompiledScene, pixel: f64) -> Self {
        // Numbers along an axis have room for this.
        let scale = (SIDE * pixel).clamp(4.0 / f64::from(1u32 << (AXIS_BITS - 1)), 0.25);
        Self { cells: Vec::new(), eye: scene.camera.location, scale, found: Candidates::default() }
    }

    /// The primitives that a shadow ray from `point` to the lamp may meet; `None` where that is not known.
    #[inline]
    pub fn list(&mut self, scene: &CompiledScene, (light_ix, place): (u32, &LampPlace), point: DVec3, spread: Spread) -> Option<&[u32]> {
        let away = point - self.eye;
        let reach = away.abs().max_element();
        // The exponent of the cell's side.
        let level = ((reach * self.scale).to_bits() >> 52) + spread as u64;
        if !(1023 - 60..1023 + 60).contains(&level) || light_ix >= 0xffff {
            return None;
        }
        let per_side = f64::from_bits((2 * 1023 - level) << 52);
        const MIDDLE: f64 = (1u32 << (AXIS_BITS - 1)) as f64;
        let at = away * per_side + MIDDLE;
        let at = [at.x as u32, at.y as u32, at.z as u32];
        let cell = u64::from(at[0]) << (2 * AXIS_BITS) | u64::from(at[1]) << AXIS_BITS | u64::from(at[2]);
        let key = (cell << 7 | (level & 127)) << 16 | u64::from(light_ix + 1);
        if self.cells.is_empty() {
            self.cells = vec![Cell::EMPTY; N_CELLS];
        }
        let slot = (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> (64 - N_CELLS.trailing_zeros())) as usize;
        let known = &mut self.cells[slot];
        if known.key != key {
            *known = Cell { key, ..Cell::EMPTY };
        }
        if known.n_asked < ENOUGH {
            known.n_asked += 1;
            if known.n_asked < ENOUGH {
                return None;
            }
            let side = per_side.recip();
            let min = self.eye + (DVec3::new(at[0].into(), at[1].into(), at[2].into()) - MIDDLE) * side;
            // What roundings of the numbers above may lose.
            let pad = 1e-6 * side + 1e-12 * (self.eye.abs().max_element() + reach);
            let cell = Bounds { min: min - pad, max: min + side + pad };
            known.n = between(scene, &cell, place, &mut self.found, &mut known.prims);
        }
        known.prims.get(..usize::from(known.n))
    }
}

/// Puts what may stand between a cell and a lamp into `out` and gives its number.
#[inline(never)]
fn between(scene: &CompiledScene, cell: &Bounds, place: &LampPlace, found: &mut Candidates, out: &mut [u32; MOST]) -> u16 {
    let g = &scene.geometry;
    let Some(bounds) = g.tree.shaft_bounds() else { return CROWDED };
    let whole = bounds.to_bounds();
    let corners = cell.corners();
    // Beyond the tree's box nothing but planes and the like matters.
    let reach = (whole.max - cell.min).abs().max((whole.min - cell.max).abs()).length() + cell.size().length();
    let mut points = [DVec3::ZERO; 16];
    points[..8].copy_from_slice(&corners);
    for k in 0..8 {
        points[8 + k] = match place.0 {
            End::Toward(dir) => corners[k] + reach * dir,
            End::Within(b) if b.min == b.max => {
                let way = b.min - corners[k];
                corners[k] + (reach / way.length().max(reach)) * way
            }
            End::Within(b) => b.corners()[k],
        };
    }
    let mut normals = [DVec3::ZERO; 12];
    for (k, axis) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
        // The edges along the axis, by the corners that they begin at.
        let (u, v) = (1 << ((k + 1) % 3), 1 << ((k + 2) % 3));
        for (j, corner) in [0, u, v, u | v].into_iter().enumerate() {
            normals[4 * k + j] = match place.0 {
                End::Toward(dir) if j == 0 => axis.cross(dir),
                End::Within(b) => {
                    // Planes through other edges than those of the outline, seen from the lamp, cut nothing off.
                    let lamp = b.center();
                    let shows =
                        |axis: usize, bit: usize| if corner & bit != 0 { lamp[axis] > cell.max[axis] } else { lamp[axis] < cell.min[axis] };
                    if shows((k + 1) % 3, u) == shows((k + 2) % 3, v) {
                        continue;
                    }
                    axis.cross(lamp - corners[corner])
                }
                End::Toward(_) => continue,
            };
        }
    }
    if !g.tree.gather(&Shaft::around(&points, &normals, bounds), 2 * MOST, found) {
        return CROWDED;
    }
    // The tree's primitives are looked at as far as the tree goes, those without bounds as far as the lamp.
    let mut whole_way = points;
    match place.0 {
        End::Within(b) => whole_way[8..].copy_from_slice(&b.corners()),
        End::Toward(dir) => whole_way[8..].iter_mut().for_each(|p| *p += 1e7 * dir),
    }
    let bounded = found.prims().map(|k| (g.bounded[k as usize], &points));
    let unbounded = g.unbounded.iter().map(|k| (*k, &whole_way));
    let mut n = 0;
    for (prim_ix, hull) in bounded.chain(unbounded) {
        let prim = &g.prims[prim_ix as usize];
        if prim.flags & prim_flags::NO_SHADOW != 0 || is_clear_of(g, prim, hull) {
            continue;
        }
        if n == MOST {
            return CROWDED;
        }
        out[n] = prim_ix;
        n += 1;
    }
    // What ends a ray first.
    out[..n].sort_by_key(|p| g.prims[*p as usize].flags & prim_flags::TRANSPARENT);
    n as u16
}

/// Whether the surface of a primitive lies outside the hull of `points` although its box does not: a room around them, a solid beside them that stands
/// askew, a plane that they are on one side of.
fn is_clear_of(g: &Geometry, prim: &Prim, points: &[DVec3; 16]) -> bool {
    const SLACK: f64 = 1e-6;
    if prim.flags & prim_flags::MOVING != 0 {
        return false;
    }
    let ix = prim.shape_ix as usize;
    let s = &g.shapes;
    let t = &g.transforms[prim.transform_ix as usize];
    let is_aside = |heights: &mut dyn Iterator<Item = f64>, low: f64, high: f64| {
        let (lo, hi) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), h| (h.min(lo), h.max(hi)));
        let pad = SLACK * (1.0 + low.abs() + high.abs());
        lo > high + pad || hi < low - pad
    };
    let beside = |b: Bounds| {
        let local = points.map(|p| t.inverse_point(p));
        (0..3).any(|k| is_aside(&mut local.iter().map(|p| p[k]), b.min[k], b.max[k]))
    };
    let around = |is_inside: &dyn Fn(DVec3) -> bool| points.iter().all(|p| is_inside(t.inverse_point(*p)));
    let column = |low: f64| Bounds { min: DVec3::new(-1.0, -1.0, low), max: DVec3::ONE };
    match prim.kind {
        PrimKind::Sphere => {
            let s = &s.spheres[ix];
            around(&|p| (p - s.center).length_squared() < s.radius * s.radius * (1.0 - SLACK))
        }
        PrimKind::Box => {
            let b = &s.boxes[ix];
            let pad = SLACK * (b.max - b.min);
            around(&|p| p.cmpgt(b.min + pad).all() && p.cmplt(b.max - pad).all())
                || prim.transform_ix != 0 && beside(Bounds { min: b.min, max: b.max })
        }
        PrimKind::Cylinder => beside(column(0.0)),
        PrimKind::Cone => beside(column(s.cones[ix].low)),
        PrimKind::Disc => is_aside(&mut points.iter().map(|p| t.inverse_point(*p).z), 0.0, 0.0),
        PrimKind::Plane => {
            let s = &s.planes[ix];
            is_aside(&mut points.iter().map(|p| s.normal.dot(t.inverse_point(*p))), s.distance, s.distance)
        }
        PrimKind::Triangle => {
            let s = &s.triangles[ix];
            is_aside(&mut points.iter().map(|p| s.normal.dot(*p)), s.distance, s.distance)
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::{CompileOptions, compile_scene};
    use crate::diag::Sink;
    use crate::kernel::light::light_ray;
    use crate::kernel::traverse::{Among, ClearPrims, ShadowHints, ShadowHit, intersect_shadow, intersect_shadow_noting};
    use crate::math::random::SplitMix64;
    use crate::math::{Ray, Vec3};
    use crate::scene::shape::Shape;
    use crate::scene::{Object, Scene};

    /// A room with balls in it, a floor and lamps of every kind.
    fn room() -> CompiledScene {
        let mut numbers = SplitMix64(3);
        let mut objects: Vec<Object> =
            (0..60).map(|_| Object::new(Shape::Sphere { center: 5.0 * numbers.cube(), radius: 0.1 + 0.4 * numbers.unit() })).collect();
        objects.push(Object::new(Shape::Sphere { center: DVec3::ZERO, radius: 200.0 }));
        objects.push(Object::new(Shape::Box { min: DVec3::splat(-40.0), max: DVec3::splat(40.0) }));
        objects.push(Object::new(Shape::Plane { normal: DVec3::Y, distance: -3.0 }));
        let point = Light::point(DVec3::new(4.0, 12.0, -3.0), Vec3::ONE);
        let parallel = Light { parallel: true, point_at: DVec3::ZERO, ..point.clone() };
        let far = Light::point(DVec3::new(3e4, 5e4, 1e4), Vec3::ONE);
        let sun = Light { kind: LightKind::Sun { direction: DVec3::new(0.3, -0.9, 0.2).normalize(), angle_rad: 0.0 }, ..point.clone() };
        let scene = Scene { objects, lights: vec![point, parallel, far, sun], ..Scene::default() };
        compile_scene(&scene, &CompileOptions::default(), &mut Sink::default()).expect("a scene that compiles")
    }

    #[test]
    fn lists_hold_all_that_shadow_rays_meet_and_little_else() {
        let scene = room();
        let mut cells = OcclusionCells::new(&scene, 0.01);
        let mut numbers = SplitMix64(5);
        let (mut n_known, mut n_empty, mut n_stopped) = (0, 0, 0);
        for k in 0..4000u32 {
            let (light_ix, middle) = (k % 4, 6.0 * numbers.cube());
            let light = &scene.lights[light_ix as usize];
            let place = LampPlace::of(light).expect("a lamp with shadows");
            for _ in 0..2 * ENOUGH {
                let point = middle + 0.02 * numbers.cube();
                let way = light_ray(&light.light, point, DVec3::ZERO);
                let (ray, far) = (Ray::new(point, way.dir), way.distance - 1e-3);
                let Some(list) = cells.list(&scene, (light_ix, &place), point, if k % 2 == 0 { Spread::Surface } else { Spread::Medium })
                else {
                    continue;
                };
                let hints = ShadowHints { among: Among::Few(list), ..ShadowHints::NONE };
                let stops = |hit: ShadowHit| matches!(hit, ShadowHit::Opaque { .. });
                let told = stops(intersect_shadow_noting(&scene, &ray, 1e-3, far, &hints, &mut ClearPrims::default()));
                assert_eq!(told, stops(intersect_shadow(&scene, &ray, 1e-3, far, u32::MAX)), "{ray:?} to lamp {light_ix}, {list:?}");
                (n_known, n_empty, n_stopped) = (n_known + 1, n_empty + u32::from(list.is_empty()), n_stopped + u32::from(told));
            }
        }
        assert!(n_known > 15_000 && n_empty > 500 && n_stopped > 1000, "{n_known} {n_empty} {n_stopped}");
    }
}
