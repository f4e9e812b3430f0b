//! Checks that compiled geometry holds what it promises: every index in its table, every program inside its range.

use super::NONE;
use super::geometry::{Geometry, InsideProgram, InsideStep, PrimKind, prim_flags};
use super::programs::stack_depth;

impl Geometry {
    /// Number of shapes in the table of `kind`.
    fn n_shapes(&self, kind: PrimKind) -> usize {
        let s = &self.shapes;
        match kind {
            PrimKind::Sphere => s.spheres.len(),
            PrimKind::Box => s.boxes.len(),
            PrimKind::Cylinder => s.cylinders.len(),
            PrimKind::Cone => s.cones.len(),
            PrimKind::Plane => s.planes.len(),
            PrimKind::Disc => s.discs.len(),
            PrimKind::Torus => s.tori.len(),
            PrimKind::Triangle => s.triangles.len(),
            PrimKind::Mesh | PrimKind::BicubicPatch => s.meshes.len(),
            PrimKind::Polygon => s.polygons.len(),
            PrimKind::Quadric => s.quadrics.len(),
            PrimKind::Poly => s.polys.len(),
            PrimKind::Blob => s.blobs.len(),
            PrimKind::Lathe => s.lathes.len(),
            PrimKind::Sor => s.sors.len(),
            PrimKind::Prism => s.prisms.len(),
            PrimKind::SphereSweep => s.sphere_sweeps.len(),
            PrimKind::Superellipsoid => s.superellipsoids.len(),
            PrimKind::Ovus => s.ovi.len(),
            PrimKind::JuliaFractal => s.julias.len(),
            PrimKind::HeightField => s.height_fields.len(),
            PrimKind::Isosurface => s.isosurfaces.len(),
            PrimKind::Parametric => s.parametrics.len(),
            PrimKind::Glyph => s.glyphs.len(),
            PrimKind::Hair => s.hairs.len(),
        }
    }

    /// What is wrong, if anything. Costs a walk over all tables: for tests, debug builds and uploads.
    pub fn validate(&self, n_interiors: usize) -> Result<(), String> {
        let check = |ok: bool, what: &dyn Fn() -> String| if ok { Ok(()) } else { Err(what()) };
        check(self.prims.len() == self.bounds.len(), &|| "a primitive without bounds".into())?;
        check(self.transforms.first().is_some_and(|t| t.is_identity()), &|| "transform 0 is not the identity".into())?;
        for (k, p) in self.prims.iter().enumerate() {
            check((p.shape_ix as usize) < self.n_shapes(p.kind), &|| format!("primitive {k}: no such {:?}", p.kind))?;
            check((p.transform_ix as usize) < self.transforms.len(), &|| format!("primitive {k}: no such transform"))?;
            check((p.surface_ix as usize) < self.surfaces.len(), &|| format!("primitive {k}: no such surface"))?;
            let hidden = p.flags & prim_flags::HIDDEN != 0;
            check(hidden || (p.interior_ix as usize) < n_interiors, &|| format!("primitive {k}: no such interior"))?;
            let object = self.objects.get(p.object_ix as usize);
            check(object.is_some_and(|o| o.prims.contains(&(k as u32))), &|| format!("primitive {k} is not in its object"))?;
            self.validate_program(InsideProgram { start: p.clip_start, len: p.clip_len })?;
        }
        for s in &self.surfaces {
            check((s.transform_ix as usize) < self.transforms.len(), &|| "a surface without its transform".into())?;
        }
        for (k, o) in self.objects.iter().enumerate() {
            self.validate_program(o.inside)?;
            check(!o.visible || (o.interior_ix != NONE && (o.interior_ix as usize) < n_interiors), &|| format!("object {k}: no interior"))?;
            let bounds = self.bounding_objects.get(o.bounded_by.start as usize..o.bounded_by.end as usize);
            let hidden = |b: &u32| self.objects.get(*b as usize).is_some_and(|o| !o.visible);
            check(bounds.is_some_and(|b| b.iter().all(hidden)), &|| format!("object {k}: bounding objects out of range"))?;
            check((o.cutaway.end as usize) <= self.cutaway_parts.len(), &|| format!("object {k}: cutaway parts out of range"))?;
        }
        let mut listed: Vec<u32> = self.bounded.iter().chain(&self.unbounded).copied().collect();
        listed.sort_unstable();
        let n = listed.len();
        listed.dedup();
        check(n == listed.len(), &|| "a primitive is listed twice".into())?;
        let visible = |ix: &u32| self.prims.get(*ix as usize).is_some_and(|p| p.flags & prim_flags::HIDDEN == 0);
        check(listed.iter().all(visible), &|| "a hidden primitive is listed".into())
    }

    fn validate_program(&self, p: InsideProgram) -> Result<(), String> {
        let steps = self.clip_steps.get(p.start as usize..p.start as usize + p.len as usize).ok_or("a program out of range")?;
        for (k, s) in steps.iter().enumerate() {
            let left = (steps.len() - k - 1) as u32;
            let ok = match *s {
                InsideStep::Prim(ix) | InsideStep::RequireIn(ix) | InsideStep::RequireOut(ix) => (ix as usize) < self.prims.len(),
                InsideStep::SkipOwn { first, count, skip } => skip <= left && (first as usize + count as usize) <= self.prims.len(),
                InsideStep::SkipOutside { box_ix, skip } | InsideStep::FalseOutside { box_ix, skip } => {
                    skip <= left && (box_ix as usize) < self.clip_boxes.len()
                }
                InsideStep::And | InsideStep::Or | InsideStep::Not | InsideStep::Require => true,
            };
            if !ok {
                return Err(format!("step {k} of a program: {s:?}"));
            }
        }
        if stack_depth(steps) > InsideProgram::MAX_DEPTH { Err("a program is too deep".into()) } else { Ok(()) }
    }
}
