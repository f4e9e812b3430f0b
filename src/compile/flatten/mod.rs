//! Objects → primitives: nesting, inheritance and CSG are resolved here.
//!
//! First the object's tree becomes `Node`s whose leaves are primitives (inversions pushed down, De Morgan); then every leaf gets
//! its clip program and its bounds from the nodes above it. Source: spec/objects.md, section 13.

mod bounding;
mod clip;
mod hierarchy;
mod inherited;
mod prims;
mod trees;

pub(super) use bounding::n_top_level;

use super::extent::pov_extent_in;
use super::geometry::{Geometry, InsideProgram, ObjectRecord, PhotonTarget, prim_flags};
use super::leaf::LeafTables;
use super::motion::Motion;
use super::programs::{Node, NodeKind};
use super::tables::{SurfaceTable, TransformTable};
use super::texture::TextureBuilder;
use super::{CompileError, CompileOptions, CompiledLight, Interior, LightBeam, LightGroup, Media, NONE};
use crate::accel::{Accel, AccelKind, AccelOptions};
use crate::math::{Bounds, Rgbft, Transform};
use crate::memory::MemoryLimit;
use crate::scene::{self, Csg, Light, Object, Shape, Texture};
use bounding::{BOXES_FROM, open_ended};
use inherited::Inherited;
use std::sync::Arc;
use trees::{BoundedPrims, SolidPrims};

/// Deepest nesting of objects; the compile step recurses.
const MAX_NESTING: usize = 200;

/// Memory is looked at each time this many bytes were taken.
const CHARGE: usize = 16 << 20;
/// Bytes of a node while its object is compiled; of a primitive's share of the tree while that is built.
const NODE_COST: usize = 512;
const TREE_COST: usize = 256;

/// Primitives of a scene cost several times what triangles do.
pub(super) const SCENE_TREE: AccelOptions =
    AccelOptions { intersect_cost: 4.0, max_leaf: 1, pack: 1, max_refs_per_prim: 8.0, in_runs: false };

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

    /// The finished tables of what `scene` brought.
    pub fn finish(mut self, scene: &scene::Scene) -> (Geometry, Self) {
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
        if self.n_top_level >= BOXES_FROM {
            hierarchy::sort_solids(&mut geometry, scene);
        }
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
        let mut i = above.entered(object);
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
            if role == Role::Visible && record.solid && record.inside.len > 0 {
                // POV-Ray looks at its own box first: nobody starts in the outside of an inverted ball but within the box around it.
                let mut starts = record.inside_bounds;
                if starts.is_unbounded() {
                    starts = starts.intersection(open_ended(pov_extent_in(object, &entered.to_world)));
                }
                self.geometry.solids.push((starts, object_ix));
            }
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

    fn enter_child(&mut self, child: &Object, above: &Inherited) -> Inherited {
        let role = if above.flags & prim_flags::HIDDEN != 0 { Role::Hidden } else { Role::Visible };
        self.enter(child, above, role)
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
        Some(Node::new(kind, [bounds, cobounds], surface_bounds, solid))
    }
}
