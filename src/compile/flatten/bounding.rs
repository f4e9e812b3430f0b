//! `bounded_by`, and the boxes that POV-Ray puts around objects: a ray that misses them misses the object, whatever sticks out.

use super::super::CompileError;
use super::super::extent::pov_extent_in;
use super::super::geometry::{PrimKind, prim_flags};
use super::super::leaf::padded;
use super::super::programs::{Node, NodeKind};
use super::{Flattener, Inherited, Role, is_taken_apart};
use crate::math::{Bounds, DVec3};
use crate::scene::{self, Object, Shape};

/// POV-Ray looks at boxes from so many objects at the top on.
pub(super) const BOXES_FROM: usize = 3;

/// Objects looked at to count those at the top; unions may hold each other 2^40 times, with nothing in them.
const MAX_COUNTED: usize = 10_000;

/// Objects at the top of a scene as POV-Ray counts them, up to [`BOXES_FROM`]: parts of unions that are taken apart one by one, and lamps too
/// (measured).
pub(in crate::compile) fn n_top_level(scene: &scene::Scene) -> usize {
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

/// A box whose sides at the limit of the world are no sides.
pub(super) fn open_ended(b: Bounds) -> Bounds {
    let huge = Bounds::UNBOUNDED;
    Bounds {
        min: DVec3::select(b.min.cmple(huge.min), DVec3::NEG_INFINITY, b.min),
        max: DVec3::select(b.max.cmpge(huge.max), DVec3::INFINITY, b.max),
    }
}

impl Flattener {
    /// Compiles the bounding objects of a top-level object for exact tests.
    pub(super) fn bound_exactly(&mut self, object: &Object, entered: &Inherited, object_ix: u32) -> Result<(), CompileError> {
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
    pub(super) fn flag_bounded(&mut self, prims: std::ops::Range<u32>, holds: impl Fn(&Self, &Bounds) -> bool) {
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
    pub(super) fn cull_box(&self, object: &Object, entered: &Inherited, surface: &Bounds) -> Option<Bounds> {
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
    pub(super) fn apply_bounds(&mut self, object: &Object, space: &Inherited, node: &mut Node) -> Result<(), CompileError> {
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
}
