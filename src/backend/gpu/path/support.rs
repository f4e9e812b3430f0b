//! What the path integrator on the GPU declines. Everything here gives one line that names the feature; the caller renders on the CPU
//! instead. UNSUPPORTED.md has the same list, under "GPU".

use crate::compile::geometry::{PrimKind, prim_flags};
use crate::compile::texture::TextureNode;
use crate::compile::{CompiledScene, NONE};
use crate::integrate::path::PathPlan;
use crate::integrate::path::lights::environment::Kind;
use crate::math::{DMat3, DVec3, Transform};
use crate::scene::Projection;

/// The first obstacle, if there is one. What a material alone asks for is found when it is encoded.
pub(super) fn first_obstacle(scene: &CompiledScene, plan: &PathPlan) -> Option<String> {
    let g = &scene.geometry;
    let shown = || g.prims.iter().filter(|p| p.flags & prim_flags::HIDDEN == 0);
    if let Some(p) = shown().find(|p| !matches!(p.kind, PrimKind::Mesh | PrimKind::BicubicPatch | PrimKind::Hair)) {
        return Some(format!("path tracing of {} objects", super::super::support::object_name(p.kind)));
    }
    let plain = |ix: u32| ix != NONE && !matches!(scene.textures.textures[ix as usize], TextureNode::Principled(_));
    let of_mesh = |p: &crate::compile::geometry::Prim| {
        p.kind != PrimKind::Hair && g.shapes.meshes[p.shape_ix as usize].textures.iter().any(|t| plain(*t))
    };
    let listed = [
        (shown().any(|p| plain(g.surfaces[p.surface_ix as usize].texture) || of_mesh(p)), "POV-Ray's textures"),
        (shown().any(|p| p.clip_len > 0 || p.flags & (prim_flags::BOUNDED | prim_flags::INVERTED) != 0), "clipped meshes"),
        (shown().any(|p| p.kind == PrimKind::Hair && p.flags & prim_flags::MOVING != 0), "hair that moves"),
        (shown().any(|p| p.kind == PrimKind::Hair && !is_even(&g.transforms[p.transform_ix as usize])), "hair that is stretched"),
        (crate::integrate::path::has_catchers(scene), "shadow catchers"),
        (!plan.lights.plain.is_empty(), "light sources of POV-Ray"),
        (matches!(plan.lights.environment.kind, Kind::Pov), "POV-Ray's sky"),
        (plan.lights.environment.for_camera.is_some(), "a world that the camera sees otherwise"),
        (!is_done(&scene.camera.projection), "POV-Ray's cameras"),
    ];
    listed.iter().find(|(holds, _)| *holds).map(|(_, what)| format!("path tracing of {what}"))
}

fn is_done(p: &Projection) -> bool {
    matches!(p, Projection::Perspective | Projection::Orthographic | Projection::Panorama(_) | Projection::Fisheye { .. })
}

/// Whether a transform is as long along all directions: ribbons keep their shape.
fn is_even(t: &Transform) -> bool {
    let m = t.forward.matrix3;
    let (scale, square) = (m.determinant().abs().powf(2.0 / 3.0), m.transpose() * m);
    square.abs_diff_eq(DMat3::from_diagonal(DVec3::splat(scale)), 1e-4 * scale)
}
