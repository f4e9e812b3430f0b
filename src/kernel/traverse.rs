//! Rays against the whole scene: nearest hit, shadow hit, first hit of one object. Clip programs decide which hits stand.
//!
//! Ray directions are unit: depths are world lengths.

use super::SurfaceHit;
use super::inside::{inside_object, run_program};
use super::intersect::{HitSink, LocalRay, Part, intersect_shape, plain_normal, quadrics, shape_uv, simple, triangle, world_normal};
use super::offers::{Offers, Slabs};
use crate::accel::Candidates;
use crate::compile::CompiledScene;
use crate::compile::geometry::{Geometry, InsideProgram, Prim, PrimKind, prim_flags};
use crate::math::{DVec2, DVec3, Ray, Transform};

/// Smallest depth that any ray but a shadow ray accepts. Source: spec/objects.md, section 0.
pub const MIN_DEPTH: f64 = 1e-4;
/// Shadow rays see depths above this, and below the light's distance less this. Source: spec/light.md, section 0.
pub const SHADOW_TOLERANCE: f64 = 1e-3;

/// Depths of two objects that differ by less than this share of them are one: surfaces that lie on each other, but for rounding.
const TIE: f64 = 1e-14;

/// The time at which moving objects stand where their transforms say.
pub const REST: f64 = -1.0;

/// What stands between a point and a light.
#[derive(Clone, Copy, Debug)]
pub enum ShadowHit {
    /// Nothing.
    None,
    /// Something that lets no light through.
    Opaque {
        /// What: try it first for the next ray.
        prim_ix: u32,
    },
    /// No opaque thing anywhere; this is the nearest of those that may let light through.
    Transparent(SurfaceHit),
}

/// Nearest hit of `ray` with `t_min <= t < t_max` on primitives without any of `skip_flags` (`prim_flags`). Where surfaces of two objects lie
/// on each other, the one stands that POV-Ray shows.
pub fn intersect(scene: &CompiledScene, ray: &Ray, t_min: f64, t_max: f64, skip_flags: u32) -> Option<SurfaceHit> {
    let mut nearest = Nearest { tie: TIE, ..Nearest::new(scene, ray, t_min, t_max) };
    for_candidates(&scene.geometry, &mut nearest, skip_flags);
    nearest.finish()
}

/// Nearest hit of a ray that runs below a surface that light scatters under: hits near its start count, whatever the shape.
pub fn intersect_below(scene: &CompiledScene, ray: &Ray, t_min: f64, t_max: f64) -> Option<SurfaceHit> {
    let mut nearest = Nearest { tie: TIE, below_surface: true, ..Nearest::new(scene, ray, t_min, t_max) };
    for_candidates(&scene.geometry, &mut nearest, 0);
    nearest.finish()
}

/// Nearest hit with moving objects where they are at `time` (0..=1 over the shutter; [`REST`]: as they stand). Of surfaces that lie on each other
/// the one stands that is nearer by rounding, at equal depth the one that was declared first.
pub fn intersect_at(scene: &CompiledScene, ray: &Ray, time: f64, t_min: f64, t_max: f64, skip_flags: u32) -> Option<SurfaceHit> {
    let mut nearest = Nearest::new(scene, ray, t_min, t_max);
    nearest.time = time;
    for_candidates(&scene.geometry, &mut nearest, skip_flags);
    nearest.finish()
}

/// Nearest hit of `ray` with object `object_ix` (visible or hidden) alone.
pub fn intersect_object(scene: &CompiledScene, object_ix: u32, ray: &Ray, t_min: f64, t_max: f64) -> Option<SurfaceHit> {
    intersect_object_at(scene, object_ix, ray, REST, t_min, t_max)
}

/// As [`intersect_object`], with a moving object where it is at `time`.
pub fn intersect_object_at(scene: &CompiledScene, object_ix: u32, ray: &Ray, time: f64, t_min: f64, t_max: f64) -> Option<SurfaceHit> {
    let mut nearest = Nearest::new(scene, ray, t_min, t_max);
    nearest.time = time;
    test_object(scene, object_ix, &Slabs::new(ray), &mut nearest);
    nearest.finish()
}

/// Tests the primitives of one object.
fn test_object(scene: &CompiledScene, object_ix: u32, slabs: &Slabs, nearest: &mut Nearest) {
    let g = &scene.geometry;
    let object = &g.objects[object_ix as usize];
    for prim_ix in object.prims.clone() {
        let b = &g.bounds[prim_ix as usize];
        if g.prims[prim_ix as usize].flags & prim_flags::INSIDE_ONLY == 0 && (b.is_unbounded() || slabs.hits(b, nearest.t)) {
            nearest.test(prim_ix);
        }
    }
}

/// Where a shadow ray looks for what stands in its way.
#[derive(Clone, Copy, Debug)]
pub enum Among<'c> {
    /// In the whole scene.
    All,
    /// Of primitives with bounds it can meet these alone.
    Candidates(&'c Candidates),
}

/// What is known of a shadow ray before it is traced.
#[derive(Clone, Copy, Debug)]
pub struct ShadowHints<'c> {
    /// A primitive that is tried first, or `u32::MAX`.
    pub last: u32,
    /// Where it looks.
    pub among: Among<'c>,
}

impl ShadowHints<'_> {
    /// Nothing.
    pub const NONE: Self = Self { last: u32::MAX, among: Among::All };
}

/// What lies on `ray` with `t_min < t < t_max`: stops at the first opaque hit found anywhere. Primitives without shadow are skipped.
/// `last` (a primitive or `u32::MAX`) is tried first.
pub fn intersect_shadow(scene: &CompiledScene, ray: &Ray, t_min: f64, t_max: f64, last: u32) -> ShadowHit {
    shadow(scene, ray, REST, t_min, t_max, &ShadowHints { last, ..ShadowHints::NONE }, &mut ClearPrims::default())
}

/// As [`intersect_shadow`], noting which clear primitives lie on the way.
#[inline]
pub fn intersect_shadow_noting(
    scene: &CompiledScene,
    ray: &Ray,
    t_min: f64,
    t_max: f64,
    hints: &ShadowHints,
    noted: &mut ClearPrims,
) -> ShadowHit {
    let meets_nothing = match hints.among {
        Among::All => false,
        Among::Candidates(list) => list.is_empty() && scene.geometry.unbounded.is_empty(),
    };
    if meets_nothing {
        return ShadowHit::None;
    }
    shadow(scene, ray, REST, t_min, t_max, hints, noted)
}

/// The clear primitives that a shadow ray may meet, noted on its first walk through the scene: where nothing opaque stands in the way, the
/// rest of the ray meets nothing else.
#[derive(Clone, Copy, Debug, Default)]
pub struct ClearPrims {
    prims: [u32; MOST_CLEAR],
    /// May be more than there is room for.
    n: usize,
}

/// Places for clear primitives; where more stand in the way, each piece of the ray walks.
const MOST_CLEAR: usize = 16;

impl ClearPrims {
    /// Forgets them.
    #[inline]
    pub fn clear(&mut self) {
        self.n = 0;
    }

    #[inline]
    fn note(&mut self, prim_ix: u32) {
        if let Some(place) = self.prims.get_mut(self.n) {
            *place = prim_ix;
        }
        self.n += 1;
    }

    /// All of them; `None` when they were too many.
    #[inline]
    pub fn all(&self) -> Option<&[u32]> {
        self.prims.get(..self.n)
    }
}

/// Nearest hit of the rest of a shadow ray that passed a clear thing: of the primitives noted before, which is all that it can meet.
pub fn intersect_clear(scene: &CompiledScene, ray: &Ray, t_min: f64, t_max: f64, noted: &[u32]) -> Option<SurfaceHit> {
    let g = &scene.geometry;
    let slabs = Slabs::new(ray);
    let mut clear = Nearest::new(scene, ray, t_min.next_up(), t_max);
    for prim_ix in noted {
        let b = &g.bounds[*prim_ix as usize];
        if b.is_unbounded() || slabs.hits(b, clear.t) {
            clear.test(*prim_ix);
        }
    }
    clear.finish()
}

/// As [`intersect_shadow`], with moving objects where they are at `time`.
pub fn intersect_shadow_at(scene: &CompiledScene, ray: &Ray, time: f64, t_min: f64, t_max: f64, last: u32) -> ShadowHit {
    shadow(scene, ray, time, t_min, t_max, &ShadowHints { last, ..ShadowHints::NONE }, &mut ClearPrims::default())
}

fn shadow(
    scene: &CompiledScene,
    ray: &Ray,
    time: f64,
    t_min: f64,
    t_max: f64,
    &ShadowHints { last, among }: &ShadowHints,
    noted: &mut ClearPrims,
) -> ShadowHit {
    let g = &scene.geometry;
    // Opaque things end the ray wherever they are, so the nearest clear hit must not shorten it for them.
    let mut clear = Nearest::new(scene, ray, t_min.next_up(), t_max);
    let mut opaque = Nearest::new(scene, ray, t_min.next_up(), t_max);
    opaque.stop_at_first = true;
    (clear.time, opaque.time) = (time, time);
    let mut stops = |prim_ix: u32, prim: &Prim| {
        meets_plain(g, prim, ray, t_min, t_max).unwrap_or_else(|| {
            opaque.test(prim_ix);
            opaque.found()
        })
    };
    if let Some(prim) = g.prims.get(last as usize)
        && is_blocker(prim)
        && stops(last, prim)
    {
        return ShadowHit::Opaque { prim_ix: last };
    }
    let mut blocker = u32::MAX;
    let mut test = |prim_ix: u32| {
        let prim = &g.prims[prim_ix as usize];
        if prim.flags & prim_flags::NO_SHADOW != 0 || prim_ix == last {
            return false;
        }
        if prim.flags & prim_flags::TRANSPARENT != 0 {
            noted.note(prim_ix);
            clear.test(prim_ix);
            return false;
        }
        let is_stopped = stops(prim_ix, prim);
        if is_stopped {
            blocker = prim_ix;
        }
        is_stopped
    };
    let blocked = match among {
        Among::Candidates(list) => list.any(ray, t_min, t_max, |k| test(g.bounded[k as usize])),
        Among::All if g.tree.tests_own_boxes() => g.tree.any(ray, t_min, t_max, |k| test(g.bounded[k as usize])),
        Among::All => any_in_doubt(g, ray, t_min, t_max, &mut test),
    };
    if blocked || g.unbounded.iter().any(|p| test(*p)) {
        return ShadowHit::Opaque { prim_ix: blocker };
    }
    clear.finish().map_or(ShadowHit::None, ShadowHit::Transparent)
}

/// Whether `test` says yes to any primitive that a tree offers which does not test the primitives' own boxes. What lies behind others is asked
/// too.
#[inline(never)]
fn any_in_doubt(g: &Geometry, ray: &Ray, t_min: f64, t_max: f64, test: &mut impl FnMut(u32) -> bool) -> bool {
    let mut offers = Offers::new(g, ray);
    g.tree.any(ray, t_min, t_max, |k| {
        let prim_ix = g.bounded[k as usize];
        offers.is_worth(prim_ix, t_max) && test(prim_ix)
    })
}

/// Whether a primitive stops light for good.
#[inline]
pub(super) fn is_blocker(prim: &Prim) -> bool {
    prim.flags & (prim_flags::NO_SHADOW | prim_flags::TRANSPARENT | prim_flags::HIDDEN) == 0
}

/// Whether a ray meets, or starts in, the box and every bounding object of an object.
fn meets_bounds(scene: &CompiledScene, object_ix: u32, ray: &Ray) -> bool {
    let g = &scene.geometry;
    let object = &g.objects[object_ix as usize];
    let slabs = Slabs::new(ray);
    if object.cull_box.is_some_and(|b| !slabs.hits(&b, f64::INFINITY)) {
        return false;
    }
    let meets = |object_ix: u32| {
        let mut any = Nearest::new(scene, ray, 0.0, f64::INFINITY);
        any.stop_at_first = true;
        test_object(scene, object_ix, &slabs, &mut any);
        any.found()
    };
    let range = &object.bounded_by;
    g.bounding_objects[range.start as usize..range.end as usize].iter().all(|b| inside_object(scene, *b, ray.origin) || meets(*b))
}

/// Tests the primitives that the ray may meet and that have none of `skip_flags`: those without bounds first, then the tree's, near ones
/// first.
fn for_candidates(g: &Geometry, nearest: &mut Nearest, skip_flags: u32) {
    for prim_ix in &g.unbounded {
        if g.prims[*prim_ix as usize].flags & skip_flags == 0 {
            nearest.test(*prim_ix);
        }
    }
    if g.tree.tests_own_boxes() { closest_of(g, nearest, skip_flags, |_, _| true) } else { closest_in_doubt(g, nearest, skip_flags) }
}

/// The tree's primitives, those that are worth it.
#[inline(always)]
fn closest_of(g: &Geometry, nearest: &mut Nearest, skip_flags: u32, mut is_worth: impl FnMut(u32, f64) -> bool) {
    let (ray, t_min, t_max) = (nearest.ray, nearest.t_min, nearest.limit());
    g.tree.closest(ray, t_min, t_max, |k, far| {
        let prim_ix = g.bounded[k as usize];
        if g.prims[prim_ix as usize].flags & skip_flags != 0 || !is_worth(prim_ix, far) {
            return None;
        }
        nearest.test(prim_ix);
        let limit = nearest.limit();
        (limit < far).then_some(limit)
    });
}

#[inline(never)]
fn closest_in_doubt(g: &Geometry, nearest: &mut Nearest, skip_flags: u32) {
    let mut offers = Offers::new(g, nearest.ray);
    closest_of(g, nearest, skip_flags, |prim_ix, far| offers.is_worth(prim_ix, far));
}

/// Keeps the nearest standing hit over the primitives that it tests.
///
/// At equal depth the later primitive of the same object wins, as POV-Ray's stack of hits has it; between objects the one that POV-Ray
/// asks first ([`Nearest::comes_before`]).
pub(super) struct Nearest<'a> {
    scene: &'a CompiledScene,
    ray: &'a Ray,
    t_min: f64,
    /// Depth of the best hit, or the limit.
    pub t: f64,
    prim_ix: u32,
    part: Part,
    stop_at_first: bool,
    /// Of moving objects; below 0 they are at rest.
    time: f64,
    /// Moving object met last, and where it is.
    moved: Option<(u32, Transform)>,
    /// Object whose bounds were asked last, and the answer.
    bounds_asked: (u32, bool),
    /// Share of the depth below which depths of two objects are one, and POV-Ray's order decides; 0: the depth alone decides.
    tie: f64,
    below_surface: bool,
    // The primitive under test.
    prim: u32,
    clip: InsideProgram,
    /// Depth of the shape's ray by depth of the ray.
    per_world: f64,
}

impl<'a> Nearest<'a> {
    pub fn new(scene: &'a CompiledScene, ray: &'a Ray, t_min: f64, t_max: f64) -> Self {
        Self {
            scene,
            ray,
            t_min,
            t: t_max,
            prim_ix: u32::MAX,
            part: Part::default(),
            stop_at_first: false,
            time: REST,
            // Not a place that stands for none: a ray would write 200 bytes.
            moved: None,
            bounds_asked: (u32::MAX, true),
            tie: 0.0,
            below_surface: false,
            prim: u32::MAX,
            clip: InsideProgram::default(),
            per_world: 1.0,
        }
    }

    /// With moving objects where they are at `time`.
    #[inline]
    pub fn at_time(scene: &'a CompiledScene, ray: &'a Ray, time: f64, t_min: f64, t_max: f64) -> Self {
        Self { time, ..Self::new(scene, ray, t_min, t_max) }
    }

    /// For any hit.
    #[inline]
    pub fn first(self) -> Self {
        Self { stop_at_first: true, ..self }
    }

    /// For any hit with `t_min < t < t_max`, of a ray that was asked about an object's bounds before.
    #[inline]
    pub fn any(scene: &'a CompiledScene, ray: &'a Ray, t_min: f64, t_max: f64, bounds_asked: (u32, bool)) -> Self {
        Self { stop_at_first: true, bounds_asked, ..Self::new(scene, ray, t_min.next_up(), t_max) }
    }

    /// Object whose bounds were asked last, and the answer.
    #[inline]
    pub fn bounds_asked(&self) -> (u32, bool) {
        self.bounds_asked
    }

    #[inline]
    pub fn test(&mut self, prim_ix: u32) {
        let g = &self.scene.geometry;
        let prim: &Prim = &g.prims[prim_ix as usize];
        if prim.flags & prim_flags::BOUNDED != 0 {
            if self.bounds_asked.0 != prim.object_ix {
                self.bounds_asked = (prim.object_ix, meets_bounds(self.scene, prim.object_ix, self.ray));
            }
            if !self.bounds_asked.1 {
                return;
            }
        }
        self.prim = prim_ix;
        self.clip = InsideProgram { start: prim.clip_start, len: prim.clip_len };
        let local = if prim.flags & prim_flags::MOVING != 0 && self.time >= 0.0 {
            self.moving_ray(prim)
        } else {
            match local_ray(g, prim, self.ray) {
                Some(local) => local,
                None => return,
            }
        };
        self.per_world = local.scale;
        intersect_shape(self.scene, prim, &local, self);
    }

    /// The ray in the space of a primitive that moves.
    #[cold]
    fn moving_ray(&mut self, prim: &Prim) -> LocalRay {
        let rest = self.ray.into_object(&self.motion_of(prim)).into_object(&self.scene.geometry.transforms[prim.transform_ix as usize]);
        let len = rest.dir.length();
        LocalRay { origin: rest.origin, dir: rest.dir / len, scale: len }
    }

    /// Takes up a hit with a face of a mesh that has no clip program; of faces that are hit at once the first of the mesh stands.
    #[inline]
    pub fn push_face(&mut self, prim_ix: u32, t: f64, part: Part) {
        if t == self.t && prim_ix == self.prim_ix && part.face >= self.part.face {
            return;
        }
        (self.prim, self.clip, self.per_world) = (prim_ix, InsideProgram::default(), 1.0);
        self.push(t, part);
    }

    /// Primitive of the best hit.
    #[inline]
    pub fn prim_ix(&self) -> u32 {
        self.prim_ix
    }

    /// Where a moving primitive's object is, from where it rests.
    fn motion_of(&mut self, prim: &Prim) -> Transform {
        match self.moved {
            Some((object_ix, motion)) if object_ix == prim.object_ix => motion,
            _ => {
                let motion = motion_at(&self.scene.geometry, prim, self.time);
                self.moved = Some((prim.object_ix, motion));
                motion
            }
        }
    }

    /// Depth beyond which nothing can become the best hit any more.
    #[inline]
    pub fn limit(&self) -> f64 {
        if self.found() { self.t * (1.0 + self.tie) } else { self.t }
    }

    /// Which of two objects POV-Ray asks first, so that it is seen where both are met at one depth: what has no bounds, then those whose
    /// boxes the ray enters sooner (0 where it starts inside), then the one that was declared first. Measured: a box on a plane, in
    /// whatever order; a glass block that stands on a table, seen through itself.
    #[cold]
    fn comes_before(&self, t: f64, prim_ix: u32, other: u32) -> bool {
        /// Boxes are padded: entries that are apart by a smaller share are one.
        const APART: f64 = 1e-5;
        let (g, slabs) = (&self.scene.geometry, Slabs::new(self.ray));
        let entered = |prim_ix: u32| {
            let bounds = &g.bounds[prim_ix as usize];
            if bounds.is_unbounded() { -1.0 } else { slabs.interval(bounds).0.max(0.0) }
        };
        let (own, others) = (entered(prim_ix), entered(other));
        if (own - others).abs() > APART * own.max(others) {
            return own < others;
        }
        t < self.t || t == self.t && g.prims[prim_ix as usize].object_ix < g.prims[other as usize].object_ix
    }

    /// Whether any hit stands so far.
    #[inline]
    pub fn found(&self) -> bool {
        self.prim_ix != u32::MAX
    }

    /// The best hit with its normal and coordinates.
    #[inline(always)]
    pub fn finish(&self) -> Option<SurfaceHit> {
        if !self.found() {
            return None;
        }
        Some(surface_hit(self.scene, self.ray, self.time, self.t, self.prim_ix, &self.part))
    }
}

impl HitSink for Nearest<'_> {
    #[inline]
    fn push(&mut self, t_local: f64, part: Part) {
        let t = t_local / self.per_world;
        if !(t >= self.t_min && t <= self.limit()) {
            return;
        }
        if t >= self.t * (1.0 - self.tie) {
            let prims = &self.scene.geometry.prims;
            let stays = match prims.get(self.prim_ix as usize) {
                None => t == self.t,
                Some(best) if best.object_ix == prims[self.prim as usize].object_ix => {
                    t > self.t || t == self.t && self.prim < self.prim_ix
                }
                Some(best) if self.tie == 0.0 => prims[self.prim as usize].object_ix > best.object_ix,
                Some(_) => !self.comes_before(t, self.prim, self.prim_ix),
            };
            if stays {
                return;
            }
        }
        if self.stop_at_first && self.found() {
            return;
        }
        if self.clip.len > 0 && !run_program(self.scene, self.clip, self.prim, self.ray.at(t)) {
            return;
        }
        self.t = t;
        self.prim_ix = self.prim;
        self.part = part;
    }

    #[inline]
    fn far(&self) -> f64 {
        // Nothing is wanted any more: the shape may end its search.
        if self.stop_at_first && self.found() { f64::NEG_INFINITY } else { self.limit() * self.per_world }
    }

    fn is_below_surface(&self) -> bool {
        self.below_surface
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn within(&self) -> Option<(f64, f64)> {
        let g = &self.scene.geometry;
        let (b, prim) = (&g.bounds[self.prim as usize], &g.prims[self.prim as usize]);
        let (near, far) = Slabs::new(self.ray).interval(b);
        // The box of what moves is that of all its places; a ray that runs in a face of it may have no numbers.
        let is_usable = !b.is_unbounded() && prim.flags & prim_flags::MOVING == 0 && near.is_finite() && far.is_finite();
        is_usable.then_some((near * self.per_world, far * self.per_world))
    }
}

/// The ray in the space of a primitive at rest; `None` where it is plain before it is made unit that it misses.
#[inline(always)]
pub(super) fn local_ray(g: &Geometry, prim: &Prim, ray: &Ray) -> Option<LocalRay> {
    if prim.transform_ix == 0 {
        return Some(LocalRay { origin: ray.origin, dir: ray.dir, scale: 1.0 });
    }
    let t = &g.transforms[prim.transform_ix as usize];
    let (origin, dir) = (t.inverse_point(ray.origin), t.inverse_vector(ray.dir));
    if prim.kind == PrimKind::Box {
        // Not made unit: what POV-Ray gets of boxes that lie on others shows that it does not either.
        return Some(LocalRay { origin, dir, scale: 1.0 });
    }
    if matches!(prim.kind, PrimKind::Cylinder | PrimKind::Cone) && quadrics::surely_missed(prim.kind == PrimKind::Cone, origin, dir) {
        return None;
    }
    let len = dir.length();
    Some(LocalRay { origin, dir: dir / len, scale: len })
}

/// Whether a ray meets a primitive between two depths, neither included: told for those of which every hit stands and whose shape is among
/// the common ones, `None` for others. What [`Nearest`] says, without keeping the hit.
#[inline]
pub(super) fn meets_plain(g: &Geometry, prim: &Prim, ray: &Ray, t_min: f64, t_max: f64) -> Option<bool> {
    if prim.clip_len > 0 || prim.flags & (prim_flags::BOUNDED | prim_flags::MOVING) != 0 {
        return None;
    }
    let (ix, s) = (prim.shape_ix as usize, &g.shapes);
    let Some(local) = local_ray(g, prim, ray) else { return Some(false) };
    let mut sink = Within { per_world: local.scale, t_min, t_max, is_met: false };
    match prim.kind {
        PrimKind::Sphere => simple::intersect_sphere(&s.spheres[ix], &local, &mut sink),
        PrimKind::Box => simple::intersect_box(&s.boxes[ix], &local, &mut sink),
        PrimKind::Plane => simple::intersect_plane(&s.planes[ix], &local, &mut sink),
        PrimKind::Disc => simple::intersect_disc(&s.discs[ix], &local, &mut sink),
        PrimKind::Cylinder => quadrics::intersect_cylinder(&s.cylinders[ix], &local, &mut sink),
        PrimKind::Cone => quadrics::intersect_cone(&s.cones[ix], &local, &mut sink),
        PrimKind::Triangle => triangle::intersect_triangle(&s.triangles[ix], &local, &mut sink),
        _ => return None,
    }
    Some(sink.is_met)
}

/// Whether any hit lies between two depths of the world's ray, neither included.
struct Within {
    per_world: f64,
    t_min: f64,
    t_max: f64,
    is_met: bool,
}

impl HitSink for Within {
    #[inline(always)]
    fn push(&mut self, t_local: f64, _: Part) {
        let t = t_local / self.per_world;
        self.is_met |= t > self.t_min && t < self.t_max;
    }

    #[inline(always)]
    fn far(&self) -> f64 {
        if self.is_met { f64::NEG_INFINITY } else { self.t_max * self.per_world }
    }
}

/// Where a moving primitive's object is at `time`, from where it rests; the identity below 0 and for what stands still.
pub fn motion_at(g: &Geometry, prim: &Prim, time: f64) -> Transform {
    let motion = g.objects.get(prim.object_ix as usize).and_then(|o| o.motion.as_ref());
    motion.filter(|_| time >= 0.0).map_or(Transform::IDENTITY, |m| m.at(time))
}

/// Everything about a hit that shading asks for. Inlined, so that it is written where it stays: numbers just stored one by one and then copied
/// are waited for.
#[inline(always)]
fn surface_hit(scene: &CompiledScene, ray: &Ray, time: f64, t: f64, prim_ix: u32, part: &Part) -> SurfaceHit {
    if time >= 0.0 && scene.geometry.prims[prim_ix as usize].flags & prim_flags::MOVING != 0 {
        moving_hit(scene, ray, time, t, prim_ix, part)
    } else {
        placed_hit(scene, ray, time, t, prim_ix, part)
    }
}

#[cold]
#[inline(never)]
fn moving_hit(scene: &CompiledScene, ray: &Ray, time: f64, t: f64, prim_ix: u32, part: &Part) -> SurfaceHit {
    let g = &scene.geometry;
    let motion = motion_at(g, &g.prims[prim_ix as usize], time);
    let placed = placed_hit(scene, &ray.into_object(&motion), time, t, prim_ix, part);
    let normal = motion.normal(placed.normal).try_normalize().unwrap_or(placed.normal);
    SurfaceHit { point: ray.at(t), normal, ..placed }
}

/// The same where the object rests; its vertices are where they are at `time`.
#[inline(always)]
fn placed_hit(scene: &CompiledScene, ray: &Ray, time: f64, t: f64, prim_ix: u32, part: &Part) -> SurfaceHit {
    let g = &scene.geometry;
    let prim = &g.prims[prim_ix as usize];
    let point = ray.at(t);
    let transform = (prim.transform_ix != 0).then(|| &g.transforms[prim.transform_ix as usize]);
    // Faces know where they are met.
    let inner = transform.filter(|_| !matches!(prim.kind, PrimKind::Mesh | PrimKind::BicubicPatch));
    let local = inner.map_or(point, |t| t.inverse_point(point));
    let n = match plain_normal(g, prim, local, part) {
        Some(n) => transform.map_or(n, |t| t.normal(n)),
        None => world_normal(scene, prim, transform, local, part, time),
    };
    let n = n.try_normalize().unwrap_or(DVec3::X);
    SurfaceHit {
        t,
        prim_ix,
        face_ix: part.face,
        point,
        normal: if prim.flags & prim_flags::INVERTED != 0 { -n } else { n },
        uv: if prim.flags & (prim_flags::UV_MAPPING | prim_flags::NEEDS_UV) != 0 {
            shape_uv(g, prim, local, point, part)
        } else {
            DVec2::ZERO
        },
        barycentric: DVec2::new(part.a, part.b),
    }
}
