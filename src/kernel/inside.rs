//! Whether points are inside primitives and objects: runs the programs that the compile step wrote.

use super::intersect::inside_shape;
use crate::compile::CompiledScene;
use crate::compile::geometry::{InsideProgram, InsideStep, prim_flags};
use crate::math::{Bounds, DVec3, Ray};
use crate::savings::Saving;

/// Whether world point `p` is inside primitive `prim_ix`, its inversion applied, its clip program not.
#[inline]
pub fn inside_prim(scene: &CompiledScene, prim_ix: u32, p: DVec3) -> bool {
    let g = &scene.geometry;
    let prim = &g.prims[prim_ix as usize];
    let local = if prim.transform_ix == 0 { p } else { g.transforms[prim.transform_ix as usize].inverse_point(p) };
    inside_shape(scene, prim, local, prim.flags & prim_flags::INVERTED != 0)
}

/// Runs a program for a hit on primitive `own` (`u32::MAX` for none) at world point `p`.
pub fn run_program(scene: &CompiledScene, program: InsideProgram, own: u32, p: DVec3) -> bool {
    let g = &scene.geometry;
    let steps = &g.clip_steps[program.start as usize..(program.start + program.len) as usize];
    let (mut stack, mut depth, mut k) = (0u64, 0u32, 0usize);
    while let Some(step) = steps.get(k) {
        k += 1;
        match *step {
            InsideStep::RequireIn(ix) => {
                if !inside_prim(scene, ix, p) {
                    return false;
                }
            }
            InsideStep::RequireOut(ix) => {
                if inside_prim(scene, ix, p) {
                    return false;
                }
            }
            InsideStep::SkipOwn { first, count, skip } => {
                if own.wrapping_sub(first) < count {
                    k += skip as usize;
                }
            }
            InsideStep::SkipOutside { box_ix, skip } => {
                if !g.clip_boxes[box_ix as usize].contains(p) {
                    k += skip as usize;
                }
            }
            InsideStep::FalseOutside { box_ix, skip } => {
                if !g.clip_boxes[box_ix as usize].contains(p) {
                    stack <<= 1;
                    depth += 1;
                    k += skip as usize;
                }
            }
            InsideStep::Prim(ix) => {
                stack = stack << 1 | u64::from(inside_prim(scene, ix, p));
                depth += 1;
            }
            InsideStep::Not => stack ^= 1,
            InsideStep::And => {
                stack = (stack >> 1) & (stack | !1);
                depth -= 1;
            }
            InsideStep::Or => {
                stack = (stack >> 1) | (stack & 1);
                depth -= 1;
            }
            InsideStep::Require => {
                if stack & 1 == 0 {
                    return false;
                }
                stack >>= 1;
                depth -= 1;
            }
        }
    }
    depth == 0 || stack & 1 == 1
}

/// Whether world point `p` is inside object `object_ix` of `Geometry::objects` as a whole.
pub fn inside_object(scene: &CompiledScene, object_ix: u32, p: DVec3) -> bool {
    let object = &scene.geometry.objects[object_ix as usize];
    let b = &object.inside_bounds;
    object.inside.len > 0 && b.contains(p) && run_program(scene, object.inside, u32::MAX, p)
}

/// Places for solids whose box holds a point; where more do, all are looked through.
const N_NEAR: usize = 32;

/// Calls `f` with the interiors of all visible objects that contain `p`, in the order of [`solids`](crate::compile::geometry::Geometry::solids).
/// Source: spec/light.md, section 1.
pub fn containing_interiors(scene: &CompiledScene, p: DVec3, mut f: impl FnMut(u32)) {
    let g = &scene.geometry;
    let mut look = |(b, k): &(Bounds, u32)| {
        if b.contains(p) && inside_object(scene, *k, p) {
            f(g.objects[*k as usize].interior_ix);
        }
    };
    if !scene.options.savings.has(Saving::Interiors) {
        return g.solids.iter().for_each(look);
    }
    // A ray without length meets the boxes that its start is in.
    let (mut near, mut n) = ([0u32; N_NEAR], 0);
    g.solids_tree.closest(&Ray::new(p, DVec3::X), 0.0, 0.0, |k, _| {
        if let Some(place) = near.get_mut(n) {
            *place = k;
        }
        n += 1;
        None
    });
    if n > N_NEAR {
        return g.solids.iter().for_each(look);
    }
    near[..n].sort_unstable();
    near[..n].iter().for_each(|k| look(&g.solids[*k as usize]));
}
