//! Objects → primitives: nesting, inheritance and CSG are resolved here.
//!
//! First the object's tree becomes `Node`s whose leaves are primitives (inversions pushed down, De Morgan); then every leaf gets
//! its clip program and its bounds from the nodes above it. Source: spec/objects.md, section 13.

use super::extent::pov_extent_in;
use super::geometry::{Geometry, InsideProgram, ObjectRecord, PhotonTarget, Prim, PrimKind, Surface, prim_flags};
use super::half_spaces::{HalfSpace, MOST as MAX_HALF_SPACES, shrunk};
use super::leaf::{Degenerate, Leaf, LeafTables, add_glyph, add_leaf, padded};
use super::motion::Motion;
use super::programs::{Node, NodeKind, ProgramWriter, stack_depth};
use super::tables::{SurfaceTable, TransformTable};
use super::texture::TextureBuilder;
use super::{CompileError, CompileOptions, CompiledLight, Interior, LightBeam, LightGroup, Media, NONE};
use crate::accel::{Accel, AccelKind, AccelOptions, PrimSet};
use crate::math::{Bounds, DVec3, Rgbft, Transform};
use crate::memory::MemoryLimit;
use crate::scene::{self, Csg, Light, Object, Shape, Texture, Visibility};
use std::sync::Arc;

/// Most primitives of a scene (triangles of meshes are not counted).
const MAX_PRIMS: usize = 1 << 26;
/// Most steps of all programs.
const MAX_STEPS: usize = 1 << 26;
/// Deepest nesting of objects; the compile step recurses.
const MAX_NESTING: usize = 200;

/// Memory is looked at each time this many bytes were taken.
const CHARGE: usize = 16 << 20;
/// Bytes of a primitive with its bounds, shape and place; of a node while its object is compiled; of a primitive's share of the tree
/// while that is built.
const PRIM_COST: usize = 512;
const NODE_COST: usize = 512;
const TREE_COST: usize = 256;

/// Primitives of a scene cost several times what triangles do.
pub(super) const SCENE_TREE: AccelOptions = AccelOptions { intersect_cost: 4.0, max_leaf: 1, pack: 1, max_refs_per_prim: 8.0 };

/// The bounded primitives as a tree sees them.
struct BoundedPrims<'a> {
    geometry: &'a Geometry,
}

/// The boxes of what points can be inside.
struct SolidPrims<'a>(&'a [(Bounds, u32)]);

impl PrimSet for SolidPrims<'_> {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, k: usize) -> Bounds {
        self.0[k].0
    }
}

impl PrimSet for BoundedPrims<'_> {
    fn len(&self) -> usize {
        self.geometry.bounded.len()
    }

    fn bounds(&self, k: usize) -> Bounds {
        self.geometry.bounds[self.geometry.bounded[k] as usize]
    }

    /// Slanted rods fill little of their box: the part of the axis near the cell says where.
    fn clipped_bounds(&self, k: usize, cell: &Bounds) -> Bounds {
        let b = self.bounds(k).intersection(*cell);
        let prim = &self.geometry.prims[self.geometry.bounded[k] as usize];
        if b.is_empty() || !matches!(prim.kind, PrimKind::Cylinder | PrimKind::Cone) {
            return b;
        }
        let t = &self.geometry.transforms[prim.transform_ix as usize];
        let m = t.forward.matrix3;
        // No point of the rod is farther from the axis; the last bits are for roundings.
        let r = DVec3::splat((m.x_axis.length_squared() + m.y_axis.length_squared()).sqrt() * (1.0 + 1e-9));
        let (from, along) = (t.forward.translation, m.z_axis);
        let (mut s0, mut s1) = (0.0f64, 1.0f64);
        for axis in 0..3 {
            let (low, high) = (b.min[axis] - r[axis] - from[axis], b.max[axis] + r[axis] - from[axis]);
            if along[axis].abs() > 1e-12 {
                let (x, y) = (low / along[axis], high / along[axis]);
                s0 = s0.max(x.min(y) - 1e-9);
                s1 = s1.min(x.max(y) + 1e-9);
            } else if low > 0.0 || high < 0.0 {
                return Bounds::EMPTY;
            }
        }
        if s0 > s1 {
            return Bounds::EMPTY;
        }
        let part = Bounds::from_corners(from + s0 * along, from + s1 * along);
        b.intersection(Bounds { min: part.min - r, max: part.max + r })
    }
}

/// What a node hands down to those below it.
#[derive(Clone)]
struct Inherited {
    to_world: Transform,
    texture: Option<(Arc<Texture>, Transform)>,
    interior_texture: Option<(Arc<Texture>, Transform)>,
    interior_ix: u32,
    hollow: Option<bool>,
    /// `prim_flags` that are on.
    flags: u32,
    group_ix: u32,
    /// Share of radiosity's rays that look at it, where it is said.
    importance: Option<f64>,
    /// Photons are shot at this very object as a whole; their spacing.
    aimed_at: Option<f64>,
    depth: usize,
}

/// What an object is compiled for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// Part of the picture.
    Visible,
    /// Hit on purpose or asked for its inside, never seen.
    Hidden,
}

/// Collects the geometry, the fillings and the lights of a scene.
pub(super) struct Flattener {
    pub geometry: Geometry,
    pub interiors: Vec<Interior>,
    pub media: Vec<Media>,
    pub lights: Vec<CompiledLight>,
    pub light_groups: Vec<LightGroup>,
    pub textures: TextureBuilder,
    pub transforms: TransformTable,
    leaves: LeafTables,
    surfaces: SurfaceTable,
    nodes: Vec<Node>,
    /// Lights met inside an object that is being compiled.
    pending_lights: Vec<(Light, Inherited)>,
    default_texture: Arc<Texture>,
    /// What POV-Ray counts to decide whether it looks at boxes.
    n_top_level: usize,
    accel: AccelKind,
    memory: MemoryLimit,
    /// Bytes taken since memory was looked at.
    charged: usize,
    /// Objects entered, those too that turn out to hold nothing and so take no memory.
    n_entered: u64,
}

/// Objects inside objects that a scene may have; what holds something meets the memory limit long before.
const MAX_ENTERED: u64 = 1 << 26;
/// POV-Ray looks at boxes from so many objects at the top on.
const BOXES_FROM: usize = 3;
/// Objects looked at to count those at the top; unions may hold each other 2^40 times, with nothing in them.
const MAX_COUNTED: usize = 10_000;

/// Whether the parts of an object at the top become objects at the top themselves.
fn is_taken_apart(object: &Object) -> bool {
    object.clipped_by.is_empty()
        && !object.flags.inverse
        && match object.shape {
            Shape::Csg { op: Csg::Union, .. } => object.bounded_by.is_empty() && object.flags.split_union != Some(false),
            // A declared set carries its bounds on the node around it.
            Shape::Group { .. } => object.bounded_by.is_empty(),
            Shape::LightGroup { .. } => true,
            _ => false,
        }
}

/// Objects at the top of a scene as POV-Ray counts them, up to [`BOXES_FROM`]: parts of unions that are taken apart one by one, and lamps too
/// (measured).
pub(super) fn n_top_level(scene: &scene::Scene) -> usize {
    let mut n = scene.lights.len();
    let mut waiting: Vec<&Object> = scene.objects.iter().collect();
    for _ in 0..MAX_COUNTED {
        if n >= BOXES_FROM {
            break;
        }
        let Some(object) = waiting.pop() else { return n };
        let apart = is_taken_apart(object);
        match &object.shape {
            Shape::Csg { children, .. } if apart => {
                waiting.extend(children);
            }
            Shape::Group { child } if apart => waiting.push(child),
            Shape::LightGroup { children, lights, .. } if apart => {
                n += lights.len();
                waiting.extend(children);
            }
            _ => n += 1,
        }
    }
    BOXES_FROM
}

impl Flattener {
    /// Nothing yet; `n_top_level` objects will follow, as [`n_top_level`] counts them.
    pub fn new(textures: TextureBuilder, n_top_level: usize, options: &CompileOptions) -> Self {
        Self {
            geometry: Geometry::default(),
            interiors: Vec::new(),
            media: Vec::new(),
            lights: Vec::new(),
            light_groups: Vec::new(),
            textures,
            transforms: TransformTable::new(),
            leaves: LeafTables::new(options.accel, options.trees.clone()),
            surfaces: SurfaceTable::default(),
            nodes: Vec::new(),
            pending_lights: Vec::new(),
            default_texture: Arc::new(Texture::solid(Rgbft::BLACK)),
            n_top_level,
            n_entered: 0,
            accel: options.accel,
            memory: options.memory,
            charged: 0,
        }
    }

    /// Counts bytes that are about to be taken; looks now and then whether there are so many, and what the tree will need.
    fn charge(&mut self, bytes: usize) -> Result<(), CompileError> {
        self.charged += bytes;
        if self.charged < CHARGE {
            return Ok(());
        }
        let more = std::mem::take(&mut self.charged) + self.geometry.prims.len() * TREE_COST;
        Ok(self.memory.allows(more as u64)?)
    }

    /// Refuses what is nested too deep, or too often by doubling.
    fn count_object(&mut self, entered: &Inherited) -> Result<(), CompileError> {
        if entered.depth > MAX_NESTING {
            return Err(CompileError::TooDeep { depth: entered.depth, limit: MAX_NESTING });
        }
        self.n_entered += 1;
        if self.n_entered > MAX_ENTERED {
            return Err(CompileError::TooMany { what: "objects inside objects", count: self.n_entered, limit: MAX_ENTERED });
        }
        Ok(())
    }

    /// Adds a top-level object of the scene.
    pub fn add_visible(&mut self, object: &Object) -> Result<(), CompileError> {
        self.top_level(object, &Inherited::top(), Role::Visible)
    }

    /// Adds an object that is not part of the picture and gives its index in `Geometry::objects`.
    pub fn add_hidden(&mut self, object: &Object) -> Result<u32, CompileError> {
        let entered = self.enter(object, &Inherited::top(), Role::Hidden);
        self.record(object, &entered, Role::Hidden)
    }

    /// Adds a light of the scene.
    pub fn add_light(&mut self, light: &Light) -> Result<(), CompileError> {
        self.light(light, &Inherited::top())
    }

    /// The finished tables.
    pub fn finish(mut self) -> (Geometry, Self) {
        let mut geometry = std::mem::take(&mut self.geometry);
        geometry.shapes = std::mem::take(&mut self.leaves.shapes);
        geometry.transforms = std::mem::take(&mut self.transforms.items);
        geometry.surfaces = std::mem::take(&mut self.surfaces.items);
        for (k, (prim, bounds)) in geometry.prims.iter().zip(&geometry.bounds).enumerate() {
            if prim.flags & prim_flags::HIDDEN != 0 || bounds.is_empty() {
                continue;
            }
            if bounds.is_unbounded() {
                geometry.unbounded.push(k as u32);
            } else {
                geometry.bounded.push(k as u32);
            }
        }
        let solids = geometry.objects.iter().enumerate().filter(|(_, o)| o.visible && o.solid && o.inside.len > 0);
        geometry.solids = solids.map(|(k, o)| (o.inside_bounds, k as u32)).collect();
        geometry.solids_tree = Accel::build(AccelKind::Auto, &SolidPrims(&geometry.solids), &SCENE_TREE);
        geometry.tree = Accel::build(self.accel, &BoundedPrims { geometry: &geometry }, &SCENE_TREE);
        (geometry, self)
    }

    fn top_level(&mut self, object: &Object, above: &Inherited, role: Role) -> Result<(), CompileError> {
        let entered = self.enter(object, above, role);
        self.count_object(&entered)?;
        let apart = is_taken_apart(object);
        let inside = entered.dissolve(object);
        match &object.shape {
            Shape::Csg { children, .. } if apart => children.iter().try_for_each(|c| self.top_level(c, &inside, role)),
            Shape::Group { child } if apart => self.top_level(child, &inside, role),
            Shape::LightGroup { children, lights, global_lights } if apart => {
                let mut inside = inside;
                self.enter_light_group(&mut inside, *global_lights);
                lights.iter().try_for_each(|l| self.light(l, &inside))?;
                children.iter().try_for_each(|c| self.top_level(c, &inside, role))
            }
            Shape::Light(light) => self.light(light, &inside),
            _ => self.record(object, &entered, role).map(|_| ()),
        }
    }

    /// Notes that photons are shot at an object whose primitives begin at `first`. Lights of light groups shoot none, so that what the
    /// scene's lights do not reach is no target.
    fn photon_target(&mut self, object: &Object, entered: &Inherited, first: u32) {
        let (flags, prims) = (entered.flags, first..self.geometry.prims.len() as u32);
        if let Some(spacing) = entered.aimed_at
            && flags & (prim_flags::HIDDEN | prim_flags::NO_GLOBAL_LIGHTS) == 0
            && !prims.is_empty()
        {
            let bounds = pov_extent_in(object, &entered.to_world);
            self.geometry.photon_targets.push(PhotonTarget { prims, bounds, spacing, flags });
        }
    }

    fn enter_light_group(&mut self, inside: &mut Inherited, global_lights: Option<bool>) {
        match global_lights {
            Some(true) => inside.flags &= !prim_flags::NO_GLOBAL_LIGHTS,
            Some(false) => inside.flags |= prim_flags::NO_GLOBAL_LIGHTS,
            None if inside.group_ix == NONE => inside.flags |= prim_flags::NO_GLOBAL_LIGHTS,
            None => {}
        }
        self.light_groups.push(LightGroup { parent: inside.group_ix, lights: Vec::new() });
        inside.group_ix = self.light_groups.len() as u32 - 1;
    }

    fn light(&mut self, light: &Light, above: &Inherited) -> Result<(), CompileError> {
        let mut light = light.clone();
        let looks_like = light.looks_like.take();
        let projected = light.projected_through.take();
        light.transform(&above.to_world);
        if let Some(mut object) = looks_like {
            object.flags.no_shadow = Some(true);
            self.top_level(&object, &Inherited { interior_ix: NONE, ..above.clone() }, Role::Visible)?;
        }
        let projected_through = match projected {
            Some(object) => {
                let entered = self.enter(&object, &Inherited { to_world: above.to_world, ..Inherited::top() }, Role::Hidden);
                self.record(&object, &entered, Role::Hidden)?
            }
            None => NONE,
        };
        self.lights.push(CompiledLight { beam: LightBeam::new(&light), light, group_ix: above.group_ix, projected_through });
        let light_ix = self.lights.len() as u32 - 1;
        if let Some(g) = self.light_groups.get_mut(above.group_ix as usize) {
            g.lights.push(light_ix);
        }
        Ok(())
    }

    /// What holds for `object` itself: its own settings over those from above, still in its parent's space.
    fn enter(&mut self, object: &Object, above: &Inherited, role: Role) -> Inherited {
        let mut i = above.clone();
        i.depth += 1;
        if let Some(t) = &object.texture {
            i.texture = Some((t.clone(), i.to_world));
        }
        if let Some(t) = &object.interior_texture {
            i.interior_texture = Some((t.clone(), i.to_world));
        }
        let f = &object.flags;
        for (value, bit) in [
            (f.no_shadow, prim_flags::NO_SHADOW),
            (f.no_image, prim_flags::NO_IMAGE),
            (f.no_reflection, prim_flags::NO_REFLECTION),
            (f.no_radiosity, prim_flags::NO_RADIOSITY),
            (f.double_illuminate, prim_flags::DOUBLE_ILLUMINATE),
            (f.uv_mapping, prim_flags::UV_MAPPING),
            (f.cutaway_textures, prim_flags::CUTAWAY),
        ] {
            match value {
                Some(true) => i.flags |= bit,
                Some(false) => i.flags &= !bit,
                None => {}
            }
        }
        for (kind, bit) in [
            (Visibility::CAMERA, prim_flags::NO_IMAGE),
            (Visibility::SHADOW, prim_flags::NO_SHADOW),
            (Visibility::DIFFUSE, prim_flags::NO_DIFFUSE),
            (Visibility::GLOSSY, prim_flags::NO_GLOSSY),
            (Visibility::TRANSMISSION, prim_flags::NO_TRANSMISSION),
            (Visibility::VOLUME, prim_flags::NO_VOLUME),
        ] {
            i.flags |= if object.traits.visibility.has(kind) { 0 } else { bit };
        }
        i.flags |= if object.traits.shadow_catcher { 0 } else { prim_flags::NO_CATCHER };
        i.flags |= if object.traits.motion.len() > 1 { prim_flags::MOVING } else { 0 };
        i.enter_photons(&object.photons);
        i.hollow = f.hollow.or(i.hollow);
        i.importance = object.importance.or(i.importance);
        if role == Role::Visible
            && let Some(interior) = &object.interior
        {
            i.interior_ix = self.interior(interior, i.hollow == Some(true), &i.to_world);
        }
        i
    }

    fn interior(&mut self, interior: &scene::Interior, hollow: bool, to_world: &Transform) -> u32 {
        let media = interior.media.iter().map(|m| self.medium(m, to_world)).collect();
        self.interiors.push(Interior {
            ior: interior.ior,
            dispersion: interior.dispersion,
            dispersion_samples: interior.dispersion_samples,
            caustics: interior.caustics,
            fade_color: interior.fade_color,
            fade_distance: interior.fade_distance,
            fade_power: interior.fade_power,
            old_refraction: interior.old_refraction,
            media,
            hollow,
        });
        self.interiors.len() as u32 - 1
    }

    /// Adds a medium whose densities stand in a space that `to_world` maps to the world.
    pub fn medium(&mut self, medium: &scene::Media, to_world: &Transform) -> u32 {
        let densities = medium.densities.iter().map(|d| self.textures.pigment(d)).collect();
        let mut params = medium.clone();
        params.densities.clear();
        self.media.push(Media { params, densities, transform_ix: self.transforms.add(to_world) });
        self.media.len() as u32 - 1
    }

    /// Compiles one object as a whole; `entered` is what [`Flattener::enter`] gave for it.
    fn record(&mut self, object: &Object, entered: &Inherited, role: Role) -> Result<u32, CompileError> {
        let mut entered = entered.clone();
        if entered.interior_ix == NONE && role == Role::Visible {
            entered.interior_ix = self.interior(&scene::Interior::default(), entered.hollow == Some(true), &Transform::IDENTITY);
        }
        if role == Role::Hidden {
            entered.flags |= prim_flags::HIDDEN;
        }
        self.nodes.clear();
        let first = self.geometry.prims.len() as u32;
        let object_ix = self.geometry.objects.len() as u32;
        let root = self.node(object, &entered, false, false)?;
        let mut record = ObjectRecord {
            prims: first..self.geometry.prims.len() as u32,
            inside: InsideProgram::default(),
            bounds: Bounds::EMPTY,
            inside_bounds: Bounds::EMPTY,
            interior_ix: if role == Role::Visible { entered.interior_ix } else { NONE },
            visible: role == Role::Visible,
            solid: false,
            bounded_by: 0..0,
            cull_box: None,
            cutaway: 0..0,
            traits: object.traits.clone(),
            motion: Motion::of_object(object, &entered.to_world),
        };
        let mut keeps_bounds = false;
        if let Some(root) = root {
            record.solid = self.nodes[root].solid;
            record.inside_bounds = open_ended(self.nodes[root].bounds);
            keeps_bounds = self.nodes[root].keeps_bounds;
            let mut steps = Vec::new();
            self.writer().require(root, true, &mut steps);
            record.inside = self.add_program(&steps)?;
            self.assign(root, &[], InsideProgram::default(), Bounds::UNBOUNDED, &mut Vec::new())?;
            // A ray that meets the bounds of a set may meet it anywhere; only what has no end of its own gets theirs.
            if let (Some(holds), false) = (self.nodes[root].cull_box, matches!(self.nodes[root].kind, NodeKind::Leaf(_))) {
                for k in first as usize..self.geometry.prims.len() {
                    let leaf = &mut self.geometry.bounds[k];
                    if leaf.is_unbounded() {
                        *leaf = leaf.intersection(holds);
                    }
                }
            }
            if entered.flags & prim_flags::CUTAWAY != 0 && entered.texture.is_none() {
                let start = self.geometry.cutaway_parts.len() as u32;
                self.cutaway_parts(root)?;
                record.cutaway = start..self.geometry.cutaway_parts.len() as u32;
            }
            let leaves = first as usize..self.geometry.prims.len();
            let hit = leaves.filter(|k| self.geometry.prims[*k].flags & prim_flags::INSIDE_ONLY == 0);
            if let Some(motion) = &record.motion {
                for k in first as usize..self.geometry.prims.len() {
                    self.geometry.bounds[k] = motion.swept(&self.geometry.bounds[k]);
                }
            }
            record.bounds = hit.fold(Bounds::EMPTY, |b, k| {
                let leaf = self.geometry.bounds[k];
                if leaf.is_empty() { b } else { b.union(leaf) }
            });
        }
        if let Some(root) = root {
            record.cull_box = match self.nodes[root].kind {
                NodeKind::Leaf(_) => self.nodes[root].cull_box,
                _ => self.cull_box(object, &entered, &record.bounds),
            };
        }
        if let Some(b) = record.cull_box {
            self.flag_bounded(record.prims.clone(), |_, leaf| leaf.min.cmpge(b.min).all() && leaf.max.cmple(b.max).all());
        }
        self.geometry.objects.push(record);
        if keeps_bounds {
            self.bound_exactly(object, &entered, object_ix)?;
        }
        for (light, above) in std::mem::take(&mut self.pending_lights) {
            self.light(&light, &above)?;
        }
        Ok(object_ix)
    }

    fn writer(&mut self) -> ProgramWriter<'_> {
        ProgramWriter { nodes: &self.nodes, boxes: &mut self.geometry.clip_boxes }
    }

    fn add_program(&mut self, steps: &[super::geometry::InsideStep]) -> Result<InsideProgram, CompileError> {
        let depth = stack_depth(steps);
        if depth > InsideProgram::MAX_DEPTH {
            return Err(CompileError::TooDeep { depth, limit: InsideProgram::MAX_DEPTH });
        }
        let start = self.geometry.clip_steps.len();
        if start + steps.len() > MAX_STEPS {
            let count = (start + steps.len()) as u64;
            return Err(CompileError::TooMany { what: "steps of CSG programs", count, limit: MAX_STEPS as u64 });
        }
        self.charge(2 * size_of_val(steps))?;
        self.geometry.clip_steps.extend_from_slice(steps);
        Ok(InsideProgram { start: start as u32, len: steps.len() as u32 })
    }

    /// Adds the node of `object` and all below it. `None`: nothing there.
    fn node(&mut self, object: &Object, entered: &Inherited, inverted: bool, in_csg: bool) -> Result<Option<usize>, CompileError> {
        self.count_object(entered)?;
        self.charge(NODE_COST)?;
        let first = self.geometry.prims.len() as u32;
        let inverted = inverted ^ object.flags.inverse;
        let mut inside = entered.descend(object);
        let built = match &object.shape {
            Shape::Csg { op, children } => {
                let mut list = Vec::with_capacity(children.len());
                let mut n_solids = 0;
                for c in children {
                    if let Shape::Light(l) = &c.shape {
                        let below = self.enter(c, &inside, Role::Hidden).descend(c);
                        self.pending_lights.push(((**l).clone(), below));
                        continue;
                    }
                    let subtracted = *op == Csg::Difference && n_solids > 0;
                    n_solids += 1;
                    let below = self.enter_child(c, &inside);
                    list.extend(self.node(c, &below, inverted ^ subtracted, true)?);
                }
                let all = matches!(op, Csg::Intersection | Csg::Difference);
                let node = self.join(list, all != inverted, *op == Csg::Merge || inverted);
                node.map(|n| Node { is_difference: *op == Csg::Difference, ..n })
            }
            Shape::LightGroup { children, lights, global_lights } => {
                self.enter_light_group(&mut inside, *global_lights);
                self.pending_lights.extend(lights.iter().map(|l| (l.clone(), inside.clone())));
                let mut list = Vec::with_capacity(children.len());
                for c in children {
                    let below = self.enter_child(c, &inside);
                    list.extend(self.node(c, &below, inverted, true)?);
                }
                self.join(list, inverted, inverted)
            }
            Shape::Group { child } => {
                let below = self.enter_child(child, &inside);
                let child = self.node(child, &below, inverted, in_csg)?;
                self.join(child.into_iter().collect(), false, false)
            }
            Shape::Light(light) => {
                self.pending_lights.push(((**light).clone(), inside));
                None
            }
            Shape::Text { .. } => self.text(object, &inside, inverted)?,
            _ => self.leaf(object, &inside, inverted, in_csg)?,
        };
        let Some(mut node) = built else { return Ok(None) };
        let clip_space = Inherited {
            flags: prim_flags::HIDDEN | prim_flags::INSIDE_ONLY,
            to_world: entered.to_world,
            depth: entered.depth,
            ..Inherited::top()
        };
        // clipped_by does nothing to a patch.
        let is_patch = matches!(object.shape, Shape::BicubicPatch { .. });
        for c in object.clipped_by.iter().filter(|_| !is_patch) {
            let below = self.enter(c, &clip_space, Role::Hidden);
            if let Some(c) = self.node(c, &below, false, true)? {
                node.clips.push(c);
                let clip = &self.nodes[c];
                node.bounds = node.bounds.intersection(clip.bounds);
                node.surface_bounds = node.surface_bounds.intersection(clip.bounds);
                node.cobounds = node.cobounds.union(clip.cobounds);
            }
        }
        if !object.bounded_by.is_empty() {
            self.apply_bounds(object, &clip_space, &mut node)?;
        }
        node.prims = first..self.geometry.prims.len() as u32;
        self.photon_target(object, entered, first);
        self.nodes.push(node);
        Ok(Some(self.nodes.len() - 1))
    }

    /// Adds the leaves whose covers cut surfaces may show: of differences only the first child's.
    fn cutaway_parts(&mut self, node: usize) -> Result<(), CompileError> {
        match self.nodes[node].kind.clone() {
            NodeKind::Leaf(p) => {
                let mut steps = Vec::new();
                self.writer().require(node, true, &mut steps);
                let program = self.add_program(&steps)?;
                self.geometry.cutaway_parts.push((program, self.geometry.prims[p as usize].surface_ix));
                Ok(())
            }
            NodeKind::All(list) | NodeKind::Any(list) | NodeKind::Merge(list) => {
                let n = if self.nodes[node].is_difference { 1 } else { list.len() };
                list.iter().take(n).try_for_each(|c| self.cutaway_parts(*c))
            }
        }
    }

    fn enter_child(&mut self, child: &Object, above: &Inherited) -> Inherited {
        let role = if above.flags & prim_flags::HIDDEN != 0 { Role::Hidden } else { Role::Visible };
        self.enter(child, above, role)
    }

    /// Compiles the bounding objects of a top-level object for exact tests.
    fn bound_exactly(&mut self, object: &Object, entered: &Inherited, object_ix: u32) -> Result<(), CompileError> {
        let space = Inherited { to_world: entered.to_world, depth: entered.depth, ..Inherited::top() };
        let mut list = Vec::with_capacity(object.bounded_by.len());
        for b in &object.bounded_by {
            let below = self.enter(b, &space, Role::Hidden);
            list.push(self.record(b, &below, Role::Hidden)?);
        }
        let start = self.geometry.bounding_objects.len() as u32;
        self.geometry.bounding_objects.extend(list);
        let record = &mut self.geometry.objects[object_ix as usize];
        record.bounded_by = start..self.geometry.bounding_objects.len() as u32;
        let prims = record.prims.clone();
        let bounds = self.geometry.bounding_objects[start as usize..].to_vec();
        self.flag_bounded(prims, |f, leaf| bounds.iter().all(|b| f.surely_holds(*b, leaf)));
        Ok(())
    }

    /// Marks the primitives whose object's bounds must be asked: not those whose own box lies within, which meet them whenever they are met.
    fn flag_bounded(&mut self, prims: std::ops::Range<u32>, holds: impl Fn(&Self, &Bounds) -> bool) {
        for k in prims.start as usize..prims.end as usize {
            if !holds(self, &self.geometry.bounds[k]) {
                self.geometry.prims[k].flags |= prim_flags::BOUNDED;
            }
        }
    }

    /// Whether an object is one convex shape with the whole of `b` inside.
    fn surely_holds(&self, object_ix: u32, b: &Bounds) -> bool {
        let (g, shapes) = (&self.geometry, &self.leaves.shapes);
        let object = &g.objects[object_ix as usize];
        let [prim] = &g.prims[object.prims.start as usize..object.prims.end as usize] else { return false };
        if prim.flags & prim_flags::INVERTED != 0 || object.bounded_by.start != object.bounded_by.end || object.cull_box.is_some() {
            return false;
        }
        let (ix, to_world) = (prim.shape_ix as usize, &self.transforms.items[prim.transform_ix as usize]);
        (0..8u8).all(|corner| {
            let side = |k: u8| if corner >> k & 1 == 0 { b.min[k as usize] } else { b.max[k as usize] };
            let p = to_world.inverse_point(DVec3::new(side(0), side(1), side(2)));
            match prim.kind {
                PrimKind::Sphere => {
                    let s = &shapes.spheres[ix];
                    p.distance(s.center) < s.radius
                }
                PrimKind::Box => {
                    let s = &shapes.boxes[ix];
                    p.cmpge(s.min).all() && p.cmple(s.max).all()
                }
                PrimKind::Cylinder => p.x * p.x + p.y * p.y < 1.0 && p.z > 0.0 && p.z < 1.0,
                _ => false,
            }
        })
    }

    /// POV-Ray's box of a CSG where it leaves out some of the surface. POV-Ray looks at boxes from three objects on.
    fn cull_box(&self, object: &Object, entered: &Inherited, surface: &Bounds) -> Option<Bounds> {
        if self.n_top_level < BOXES_FROM || surface.is_empty() {
            return None;
        }
        let b = padded(pov_extent_in(object, &entered.to_world));
        let holds = b.min.cmple(surface.min).all() && b.max.cmpge(surface.max).all();
        (!b.is_unbounded() && !holds).then_some(b)
    }

    /// `bounded_by`: a ray that misses the bounds' box misses the object. POV-Ray takes bounds off simple finite objects, but for the box
    /// that is already cut, which counts where there are three objects or more, and not for shapes that work their box out anew (measured:
    /// every shape).
    fn apply_bounds(&mut self, object: &Object, space: &Inherited, node: &mut Node) -> Result<(), CompileError> {
        let composite = matches!(object.shape, Shape::Csg { .. } | Shape::Group { .. } | Shape::Poly { .. } | Shape::Text { .. });
        node.keeps_bounds = composite || node.surface_bounds.is_unbounded() || self.n_top_level == usize::MAX;
        let anew = matches!(
            object.shape,
            Shape::Blob { .. }
                | Shape::Mesh(_)
                | Shape::Triangle { .. }
                | Shape::HeightField { .. }
                | Shape::Polygon { .. }
                | Shape::JuliaFractal { .. }
                | Shape::BicubicPatch { .. }
        );
        if !node.keeps_bounds && (self.n_top_level < BOXES_FROM || anew) {
            return Ok(());
        }
        let mut holds = Bounds::UNBOUNDED;
        for b in &object.bounded_by {
            let below = self.enter(b, space, Role::Hidden);
            if let Some(b) = self.node(b, &below, false, true)? {
                holds = holds.intersection(self.nodes[b].bounds);
            }
        }
        if matches!(node.kind, NodeKind::Leaf(_)) && node.surface_bounds.is_unbounded() {
            node.surface_bounds = node.surface_bounds.intersection(holds);
        } else {
            node.cull_box = Some(holds);
        }
        Ok(())
    }

    /// A node over children: `all` for intersections, else a union whose inner surfaces go when `merge`.
    fn join(&mut self, list: Vec<usize>, all: bool, merge: bool) -> Option<Node> {
        if list.is_empty() {
            return None;
        }
        for c in &list {
            if let Some(b) = self.nodes[*c].cull_box.take() {
                self.nodes[*c].surface_bounds = self.nodes[*c].surface_bounds.intersection(b);
            }
        }
        let fold = |start: Bounds, f: fn(Bounds, Bounds) -> Bounds, of: fn(&Node) -> Bounds| {
            list.iter().fold(start, |b, c| f(b, of(&self.nodes[*c])))
        };
        let (bounds, cobounds) = if all {
            (fold(Bounds::UNBOUNDED, Bounds::intersection, |n| n.bounds), fold(Bounds::EMPTY, Bounds::union, |n| n.cobounds))
        } else {
            (fold(Bounds::EMPTY, Bounds::union, |n| n.bounds), fold(Bounds::UNBOUNDED, Bounds::intersection, |n| n.cobounds))
        };
        let surface_bounds = fold(Bounds::EMPTY, Bounds::union, |n| n.surface_bounds);
        let solid = list.iter().any(|c| self.nodes[*c].solid);
        let kind = match (all, merge) {
            (true, _) => NodeKind::All(list),
            (false, true) => NodeKind::Merge(list),
            (false, false) => NodeKind::Any(list),
        };
        Some(Node {
            kind,
            clips: Vec::new(),
            bounds,
            cobounds,
            surface_bounds,
            cull_box: None,
            prims: 0..0,
            solid,
            is_difference: false,
            keeps_bounds: false,
        })
    }

    /// A text: a plain union of its letters.
    fn text(&mut self, object: &Object, inside: &Inherited, inverted: bool) -> Result<Option<Node>, CompileError> {
        let Shape::Text { glyphs, depth } = &object.shape else { return Ok(None) };
        let mut list = Vec::with_capacity(glyphs.len());
        for g in glyphs {
            if let Some(leaf) = add_glyph(g, *depth, &inside.to_world, &mut self.leaves) {
                let first = self.geometry.prims.len() as u32;
                let mut node = self.add_prim(&leaf, inside, inverted, true)?;
                node.prims = first..first + 1;
                self.nodes.push(node);
                list.push(self.nodes.len() - 1);
            }
        }
        Ok(self.join(list, inverted, inverted))
    }

    fn leaf(&mut self, object: &Object, inside: &Inherited, inverted: bool, in_csg: bool) -> Result<Option<Node>, CompileError> {
        match add_leaf(object, &inside.to_world, &mut self.leaves, &mut self.transforms, &mut self.textures) {
            Ok(leaf) => self.add_prim(&leaf, inside, inverted, in_csg).map(Some),
            Err(Degenerate) => Ok(None),
        }
    }

    fn add_prim(&mut self, leaf: &Leaf, inside: &Inherited, inverted: bool, in_csg: bool) -> Result<Node, CompileError> {
        self.charge(PRIM_COST)?;
        if self.geometry.prims.len() >= MAX_PRIMS {
            return Err(CompileError::TooMany { what: "primitives", count: MAX_PRIMS as u64 + 1, limit: MAX_PRIMS as u64 });
        }
        // POV-Ray's patches have no inside, turned round neither: a difference that takes one off is empty but for the patch (measured).
        let inverted = inverted && leaf.solid;
        let mut flags = inside.flags;
        flags |= if inverted { prim_flags::INVERTED } else { 0 };
        flags |= if in_csg { prim_flags::CSG_CHILD } else { 0 };
        let surface_ix = self.surface(leaf, inside, &mut flags);
        if let Some(i) = self.interiors.get_mut(inside.interior_ix as usize) {
            i.hollow = inside.hollow == Some(true);
        }
        let prim_ix = self.geometry.prims.len() as u32;
        if let Some(importance) = inside.importance {
            self.geometry.importances.resize(prim_ix as usize, f64::NAN);
            self.geometry.importances.push(importance);
        }
        self.geometry.prims.push(Prim {
            kind: leaf.kind,
            shape_ix: leaf.shape_ix,
            transform_ix: self.transforms.add(&leaf.transform),
            surface_ix,
            interior_ix: inside.interior_ix,
            object_ix: self.geometry.objects.len() as u32,
            clip_start: 0,
            clip_len: 0,
            flags,
            group_ix: inside.group_ix,
        });
        self.geometry.bounds.push(leaf.surface_bounds);
        let (bounds, cobounds) = if inverted { (Bounds::UNBOUNDED, leaf.inside_bounds) } else { (leaf.inside_bounds, Bounds::UNBOUNDED) };
        let kind = NodeKind::Leaf(prim_ix);
        let surface_bounds = leaf.surface_bounds;
        Ok(Node {
            kind,
            clips: Vec::new(),
            bounds,
            cobounds,
            surface_bounds,
            cull_box: None,
            prims: 0..0,
            solid: leaf.solid,
            is_difference: false,
            keeps_bounds: false,
        })
    }

    /// The cover that a leaf gets; sets `TRANSPARENT` and `NEEDS_UV`.
    fn surface(&mut self, leaf: &Leaf, inside: &Inherited, flags: &mut u32) -> u32 {
        if *flags & prim_flags::HIDDEN != 0 {
            return self.surfaces.add(Surface { texture: NONE, interior_texture: NONE, transform_ix: 0 });
        }
        let cutaway = *flags & prim_flags::CUTAWAY != 0;
        let (texture, space) = match &inside.texture {
            Some((t, space)) => (self.textures.texture(t), *space),
            None if cutaway => (NONE, Transform::IDENTITY),
            None => (self.textures.texture(&self.default_texture.clone()), Transform::IDENTITY),
        };
        let interior_texture = match &inside.interior_texture {
            Some((t, own)) if own.forward == space.forward => self.textures.texture(t),
            Some((t, own)) => {
                let mut moved = t.clone();
                Arc::make_mut(&mut moved).transform(&own.then(&space.inverted()));
                self.textures.texture(&moved)
            }
            None => NONE,
        };
        let parts: &[u32] = match leaf.kind {
            PrimKind::Mesh => &self.leaves.shapes.meshes[leaf.shape_ix as usize].textures,
            PrimKind::Blob => &self.leaves.shapes.blobs[leaf.shape_ix as usize].textures,
            _ => &[],
        };
        let unknown = cutaway && texture == NONE;
        let covers = || [texture, interior_texture].into_iter().chain(parts.iter().copied()).filter(|t| *t != NONE);
        if unknown || covers().any(|t| self.textures.is_transparent(t)) {
            *flags |= prim_flags::TRANSPARENT;
        }
        if unknown || covers().any(|t| self.textures.needs_uv(t)) {
            *flags |= prim_flags::NEEDS_UV;
        }
        // A cover on (u, v) does not move with its object.
        let transform_ix = if *flags & prim_flags::UV_MAPPING != 0 { 0 } else { self.transforms.add(&space) };
        self.surfaces.add(Surface { texture, interior_texture, transform_ix })
    }

    /// The half-space that a node is, if it is a plane.
    fn half_space(&self, node: usize) -> Option<HalfSpace> {
        let NodeKind::Leaf(prim_ix) = self.nodes[node].kind else { return None };
        let prim = &self.geometry.prims[prim_ix as usize];
        let plane = (prim.kind == PrimKind::Plane).then(|| &self.leaves.shapes.planes[prim.shape_ix as usize])?;
        let below = HalfSpace { normal: plane.normal, limit: plane.distance };
        Some(if prim.flags & prim_flags::INVERTED != 0 { below.flipped() } else { below })
    }

    /// Gives the leaves below `node` their clip programs and bounds. `program` is `steps` as already added; `within` are half-spaces that
    /// hold what is left of them, beside `cut`.
    fn assign(
        &mut self,
        node: usize,
        steps: &[super::geometry::InsideStep],
        program: InsideProgram,
        cut: Bounds,
        within: &mut Vec<HalfSpace>,
    ) -> Result<(), CompileError> {
        let n = self.nodes[node].clone();
        let n_above = within.len();
        within.extend(n.clips.iter().filter_map(|c| self.half_space(*c)));
        let cut = cut.intersection(n.surface_bounds);
        let mut own = Vec::new();
        self.writer().conditions(node, &mut own);
        let (mut steps, mut program) = (steps, program);
        if !own.is_empty() {
            own.extend_from_slice(steps);
            program = self.add_program(&own)?;
            steps = &own;
        }
        let list = match &n.kind {
            NodeKind::Leaf(p) => {
                let prim = &mut self.geometry.prims[*p as usize];
                (prim.clip_start, prim.clip_len) = (program.start, program.len);
                let own = self.half_space(node);
                within.extend(own.into_iter().flat_map(|h| [h, h.flipped()]));
                self.geometry.bounds[*p as usize] = shrunk(cut, within);
                within.truncate(n_above);
                return Ok(());
            }
            NodeKind::All(list) | NodeKind::Any(list) | NodeKind::Merge(list) => list,
        };
        let is_all = matches!(n.kind, NodeKind::All(_));
        // Boxes of all children but one, from both ends, so that many children stay cheap.
        let after: Vec<Bounds> = list
            .iter()
            .rev()
            .scan(Bounds::UNBOUNDED, |b, c| {
                let now = *b;
                *b = b.intersection(self.nodes[*c].bounds);
                Some(now)
            })
            .collect();
        let planes: Vec<(usize, HalfSpace)> = match is_all {
            true => list.iter().filter_map(|c| Some((*c, self.half_space(*c)?))).take(MAX_HALF_SPACES + 1).collect(),
            false => Vec::new(),
        };
        let mut before = cut;
        for (k, c) in list.iter().enumerate() {
            let child_cut = if is_all { before.intersection(after[list.len() - 1 - k]) } else { cut };
            let n_here = within.len();
            within.extend(planes.iter().filter(|(plane, _)| plane != c).map(|(_, h)| *h));
            self.assign(*c, steps, program, child_cut, within)?;
            within.truncate(n_here);
            before = before.intersection(self.nodes[*c].bounds);
        }
        within.truncate(n_above);
        Ok(())
    }
}

/// A box whose sides at the limit of the world are no sides.
fn open_ended(b: Bounds) -> Bounds {
    let huge = Bounds::UNBOUNDED;
    Bounds {
        min: DVec3::select(b.min.cmple(huge.min), DVec3::NEG_INFINITY, b.min),
        max: DVec3::select(b.max.cmpge(huge.max), DVec3::INFINITY, b.max),
    }
}

impl Inherited {
    /// What the object says counts where nothing above it says otherwise.
    fn enter_photons(&mut self, p: &scene::object::PhotonFlags) {
        for (value, on, off) in [
            (p.reflection, prim_flags::PHOTON_REFLECTION, prim_flags::PHOTON_NO_REFLECTION),
            (p.refraction, prim_flags::PHOTON_REFRACTION, prim_flags::PHOTON_NO_REFRACTION),
            (p.collect, 0, prim_flags::PHOTON_NO_COLLECT),
            (p.pass_through, prim_flags::PHOTON_PASS_THROUGH, 0),
        ] {
            if self.flags & (on | off) == 0 {
                self.flags |= match value {
                    Some(true) => on,
                    Some(false) => off,
                    None => 0,
                };
            }
        }
        // Within a target all is one target; a dissolved one has handed itself down.
        if self.flags & prim_flags::PHOTON_TARGET == 0 {
            self.aimed_at = p.target;
            self.flags |= if p.target.is_some() { prim_flags::PHOTON_TARGET } else { 0 };
        }
        // Photons cannot go on straight and be bent at once.
        let both = prim_flags::PHOTON_TARGET | prim_flags::PHOTON_PASS_THROUGH;
        if self.flags & both == both && self.flags & prim_flags::PHOTON_NO_REFRACTION == 0 {
            if self.flags & prim_flags::PHOTON_REFRACTION == 0 {
                self.flags |= prim_flags::PHOTON_NO_REFRACTION;
            } else {
                self.flags &= !prim_flags::PHOTON_PASS_THROUGH;
            }
        }
    }

    fn top() -> Self {
        Self {
            to_world: Transform::IDENTITY,
            texture: None,
            interior_texture: None,
            interior_ix: NONE,
            hollow: None,
            flags: 0,
            group_ix: NONE,
            importance: None,
            aimed_at: None,
            depth: 0,
        }
    }

    /// The same for what `object` is dissolved into: where it is a photon target, each part is one.
    fn dissolve(&self, object: &Object) -> Self {
        Self { aimed_at: self.aimed_at, ..self.descend(object) }
    }

    /// The same for what stands inside `object`'s shape.
    fn descend(&self, object: &Object) -> Self {
        Self { to_world: object.transform.then(&self.to_world), aimed_at: None, ..self.clone() }
    }
}
