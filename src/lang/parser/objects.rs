//! Objects: the simple ones, and the modifiers of all. Source: spec/language.md, section 7; spec/objects.md.

use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::value::{FinishExtras, Value};
use crate::math::{DVec3, EPSILON, Transform};
use crate::scene::object::PhotonFlags;
use crate::scene::{Csg, Interior, Object, Shape, Texture};
use std::sync::Arc;

impl Parser<'_> {
    /// An object statement or an object's name, if one is next.
    pub(super) fn parse_object(&mut self) -> PResult<Option<Object>> {
        let start = self.peek()?.span;
        if let Some(Value::Object(o)) = self.peek_value()? {
            // Declared objects with children share them: this copies one node.
            let o = (**o).clone();
            self.next()?;
            return Ok(Some(o));
        }
        let Some(k) = self.peek_kw()? else { return Ok(None) };
        if !is_object_word(k) {
            return Ok(None);
        }
        self.next()?;
        let mut object = match k {
            Kw::LightGroup => self.parse_light_group()?,
            Kw::LightSource => Object::new(Shape::Light(Box::new(self.parse_light()?))),
            _ => {
                self.open_block(k.text())?;
                let o = self.nested(|p| p.object_block(k))?;
                self.close_block(k.text())?;
                o
            }
        };
        object.span = Some(start.to(self.last_span));
        Ok(Some(object))
    }

    /// An object statement where one must be.
    pub(super) fn need_object(&mut self) -> PResult<Object> {
        match self.parse_object()? {
            Some(o) => Ok(o),
            None => self.expected("object"),
        }
    }

    fn object_block(&mut self, k: Kw) -> PResult<Object> {
        // A bare name first makes the whole block a copy with modifiers, whatever the word.
        let mut object = if let Some(Value::Object(o)) = self.peek_value()? {
            let o = (**o).clone();
            self.next()?;
            o
        } else {
            match k {
                Kw::Object => self.need_object()?,
                Kw::Union | Kw::Composite => self.parse_csg(Csg::Union)?,
                Kw::Merge => self.parse_csg(Csg::Merge)?,
                Kw::Intersection => self.parse_csg(Csg::Intersection)?,
                Kw::Difference => self.parse_csg(Csg::Difference)?,
                Kw::Blob => self.parse_blob()?,
                Kw::Text => self.parse_text_object()?,
                _ => Object::new(self.parse_shape(k)?),
            }
        };
        self.object_modifiers(&mut object)?;
        Ok(object)
    }

    /// An object to be declared: one with children becomes a node around a shared child, so that copies are small. Cover, filling,
    /// clip objects and switches move to the node: both are in the same space, and what the child does not say it takes from the node.
    pub(super) fn shared(object: Object) -> Object {
        if !matches!(object.shape, Shape::Csg { .. } | Shape::LightGroup { .. }) {
            return object;
        }
        let mut node = Object { shape: Shape::Csg { op: Csg::Union, children: Vec::new() }, transform: Transform::IDENTITY, ..object };
        let mut child = Object::new(object.shape);
        child.transform = object.transform;
        // These are about the set itself.
        child.flags.cutaway_textures = node.flags.cutaway_textures;
        child.flags.split_union = node.flags.split_union;
        node.shape = Shape::Group { child: Arc::new(child) };
        node
    }

    fn parse_shape(&mut self, k: Kw) -> PResult<Shape> {
        Ok(match k {
            Kw::Sphere => {
                let center = self.parse_vector3()?;
                self.comma()?;
                Shape::Sphere { center, radius: self.parse_float()? }
            }
            Kw::Box => {
                let a = self.parse_vector3()?;
                self.comma()?;
                let b = self.parse_vector3()?;
                Shape::Box { min: a.min(b), max: a.max(b) }
            }
            Kw::Cylinder => {
                let a = self.parse_vector3()?;
                self.comma()?;
                let b = self.parse_vector3()?;
                self.comma()?;
                let radius = self.parse_float()?;
                if (a - b).length() < EPSILON {
                    return Err(self.error("Degenerate cylinder, base point = apex point."));
                }
                Shape::Cylinder { a, b, radius, open: self.accept_kw(Kw::Open)? }
            }
            Kw::Cone => {
                let a = self.parse_vector3()?;
                self.comma()?;
                let radius_a = self.parse_float()?;
                self.comma()?;
                let b = self.parse_vector3()?;
                self.comma()?;
                let radius_b = self.parse_float()?;
                if (a - b).length() < EPSILON {
                    return Err(self.error("Degenerate cone/cylinder, base point = apex point."));
                }
                Shape::Cone { a, radius_a, b, radius_b, open: self.accept_kw(Kw::Open)? }
            }
            Kw::Plane => {
                let n = self.parse_vector3()?;
                self.comma()?;
                let distance = self.parse_float()?;
                let length = n.length();
                if length < EPSILON {
                    return Err(self.error("Degenerate plane normal."));
                }
                Shape::Plane { normal: n / length, distance }
            }
            Kw::Disc => {
                let center = self.parse_vector3()?;
                self.comma()?;
                let n = self.parse_vector3()?;
                self.comma()?;
                let radius = self.parse_float()?;
                self.comma()?;
                let hole = if self.number_follows()? { self.parse_float()? } else { 0.0 };
                let normal = n.try_normalize().unwrap_or(DVec3::X);
                Shape::Disc { center, normal, radius, hole }
            }
            Kw::Torus => {
                let major = self.parse_float()?;
                self.comma()?;
                Shape::Torus { major, minor: self.parse_float()? }
            }
            Kw::Triangle => {
                let shape = Shape::Triangle { vertices: self.three_vectors()?, normals: None };
                self.check_triangle(shape)
            }
            Kw::SmoothTriangle => {
                let shape = self.smooth_triangle()?;
                self.check_triangle(shape)
            }
            Kw::Polygon => self.parse_polygon()?,
            Kw::Mesh => self.parse_mesh()?,
            Kw::Mesh2 => self.parse_mesh2()?,
            Kw::BicubicPatch => self.parse_bicubic_patch()?,
            Kw::Quadric => self.parse_quadric()?,
            Kw::Cubic => Shape::Poly { order: 3, coefficients: self.coefficients(20)? },
            Kw::Quartic => Shape::Poly { order: 4, coefficients: self.coefficients(35)? },
            Kw::Poly => {
                let order = self.poly_order()?;
                Shape::Poly { order, coefficients: self.coefficients(poly_terms(order))? }
            }
            Kw::Polynomial => self.parse_polynomial()?,
            Kw::Lathe => self.parse_lathe()?,
            Kw::Sor => self.parse_sor()?,
            Kw::Prism => self.parse_prism()?,
            Kw::SphereSweep => self.parse_sphere_sweep()?,
            Kw::Superellipsoid => {
                let v = self.parse_vector2()?;
                Shape::Superellipsoid { e: v.x, n: v.y }
            }
            Kw::Ovus => self.parse_ovus()?,
            Kw::JuliaFractal => self.parse_julia_fractal()?,
            Kw::HeightField => self.parse_height_field()?,
            Kw::Isosurface => self.parse_isosurface()?,
            Kw::Parametric => self.parse_parametric()?,
            _ => return self.expected("object"),
        })
    }

    pub(super) fn three_vectors(&mut self) -> PResult<[DVec3; 3]> {
        let mut v = [DVec3::ZERO; 3];
        for (i, v) in v.iter_mut().enumerate() {
            if i > 0 {
                self.comma()?;
            }
            *v = self.parse_vector3()?;
        }
        Ok(v)
    }

    pub(super) fn smooth_triangle(&mut self) -> PResult<Shape> {
        let (mut vertices, mut normals) = ([DVec3::ZERO; 3], [DVec3::ZERO; 3]);
        for i in 0..3 {
            if i > 0 {
                self.comma()?;
            }
            vertices[i] = self.parse_vector3()?;
            self.comma()?;
            normals[i] = self.parse_vector3()?.try_normalize().unwrap_or(DVec3::X);
        }
        Ok(Shape::Triangle { vertices, normals: Some(normals) })
    }

    /// Says so when a triangle has no area, or normals on both of its sides: it is not shown.
    fn check_triangle(&mut self, shape: Shape) -> Shape {
        if let Shape::Triangle { vertices: [a, b, c], normals } = &shape {
            let n = (*b - *a).cross(*c - *a);
            let one_sided = normals.is_none_or(|ns| ns.iter().all(|k| k.dot(n) > 0.0) || ns.iter().all(|k| k.dot(n) < 0.0));
            if n == DVec3::ZERO || !one_sided {
                self.warn("Degenerate triangle. Please remove.");
            }
        }
        shape
    }

    /// Everything after an object's geometry.
    pub(super) fn object_modifiers(&mut self, o: &mut Object) -> PResult<()> {
        let mut covered = false;
        let mut linked = false;
        loop {
            if let Some(t) = self.parse_transform()? {
                o.apply_transform(&t);
                continue;
            }
            let Some(k) = self.peek_kw()? else { break };
            match k {
                Kw::Texture | Kw::Pigment | Kw::Normal | Kw::Finish => {
                    covered = true;
                    self.cover_item(o)?;
                }
                Kw::InteriorTexture => {
                    self.next()?;
                    let texture = self.parse_texture_block()?;
                    o.interior_texture = Some(self.layer_texture(o.interior_texture.take(), texture)?);
                }
                Kw::Interior => {
                    self.next()?;
                    o.interior = Some(Arc::new(self.parse_interior(o.interior.clone())?));
                }
                Kw::Material => {
                    self.next()?;
                    let m = self.parse_material()?;
                    covered = true;
                    if let Some(t) = m.texture {
                        o.texture = Some(self.layer_texture(o.texture.take(), t)?);
                    }
                    o.interior_texture = m.interior_texture.or(o.interior_texture.take());
                    o.interior = m.interior.or(o.interior.take());
                }
                Kw::ClippedBy => {
                    self.next()?;
                    self.clip_or_bound(o, true, &mut linked)?;
                }
                Kw::BoundedBy => {
                    self.next()?;
                    self.clip_or_bound(o, false, &mut linked)?;
                }
                Kw::Photons => {
                    self.next()?;
                    let mut flags = o.photons;
                    self.object_photons(&mut flags)?;
                    o.photons = flags;
                }
                Kw::Radiosity => {
                    self.next()?;
                    o.importance = Some(self.parse_importance()?);
                }
                _ => {
                    if !self.object_switch(o, k)? {
                        break;
                    }
                }
            }
        }
        if o.interior_texture.is_some() && o.texture.is_none() {
            return Err(self.error("Interior texture requires an exterior texture."));
        }
        if covered && let Some(t) = o.texture.clone() {
            let extras = self.texture_extras(&t);
            self.apply_extras(o, extras);
        }
        Ok(())
    }

    /// The modifiers of a blob's part: transforms and cover.
    pub(super) fn cover_modifiers(&mut self, o: &mut Object) -> PResult<()> {
        loop {
            if let Some(t) = self.parse_transform()? {
                o.apply_transform(&t);
            } else if !matches!(self.peek_kw()?, Some(Kw::Texture | Kw::Pigment | Kw::Normal | Kw::Finish)) || !self.cover_item(o)? {
                return Ok(());
            }
        }
    }

    /// A texture, or a part of one, of an object; `false` when none is next.
    fn cover_item(&mut self, o: &mut Object) -> PResult<bool> {
        match self.peek_kw()? {
            Some(Kw::Texture) => {
                self.next()?;
                let texture = self.parse_texture_block()?;
                o.texture = Some(self.layer_texture(o.texture.take(), texture)?);
            }
            Some(Kw::Pigment) => {
                self.next()?;
                self.change_top_layer(o, |p, layer| {
                    layer.pigment = p.pigment_block_from(layer.pigment.clone())?;
                    Ok(())
                })?;
            }
            Some(Kw::Normal) => {
                self.next()?;
                self.change_top_layer(o, |p, layer| {
                    layer.normal = Some(p.normal_block_from(layer.normal.clone())?);
                    Ok(())
                })?;
            }
            Some(Kw::Finish) => {
                self.next()?;
                self.change_top_layer(o, |p, layer| {
                    let extras;
                    (layer.finish, extras) = p.finish_block_from(layer.finish.clone())?;
                    p.keep_extras(&layer.finish, extras);
                    Ok(())
                })?;
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// A switch of an object; `false` when the word is none.
    fn object_switch(&mut self, o: &mut Object, k: Kw) -> PResult<bool> {
        match k {
            Kw::Inverse => {
                self.next()?;
                o.flags.inverse = !o.flags.inverse;
            }
            Kw::NoShadow => {
                self.next()?;
                o.flags.no_shadow = Some(true);
            }
            Kw::UvMapping => {
                self.next()?;
                if o.texture.is_some() {
                    return Err(self.error("uv_mapping must be specified before texture."));
                }
                o.flags.uv_mapping = Some(true);
            }
            Kw::CutawayTextures => {
                self.next()?;
                if !matches!(o.shape, Shape::Csg { op: Csg::Intersection | Csg::Difference, .. } | Shape::Group { .. }) {
                    return Err(self.error("cutaway_textures can only be used with intersection and difference."));
                }
                o.flags.cutaway_textures = Some(true);
            }
            Kw::SplitUnion => {
                self.next()?;
                if !is_union(&o.shape) {
                    return Err(self.error("split_union found in non-union object."));
                }
                o.flags.split_union = Some(self.parse_float()? > 0.0);
            }
            Kw::NoImage | Kw::NoReflection | Kw::NoRadiosity | Kw::Hollow | Kw::DoubleIlluminate | Kw::Sturm | Kw::Hierarchy => {
                self.next()?;
                let fits = match k {
                    Kw::Sturm => takes_sturm(&o.shape),
                    Kw::Hierarchy => matches!(o.shape, Shape::Mesh(_) | Shape::HeightField { .. } | Shape::Blob { .. }),
                    _ => true,
                };
                if !fits {
                    return Err(self.error(format!("Keyword '{}' cannot be used with this object.", k.text())));
                }
                let on = self.parse_switch()?;
                match k {
                    Kw::NoImage => o.flags.no_image = Some(on),
                    Kw::NoReflection => o.flags.no_reflection = Some(on),
                    Kw::NoRadiosity => o.flags.no_radiosity = Some(on),
                    Kw::Hollow => o.flags.hollow = Some(on),
                    Kw::DoubleIlluminate => o.flags.double_illuminate = Some(on),
                    Kw::Sturm => o.flags.sturm = on,
                    _ => {}
                }
            }
            Kw::Dtag => {
                self.next()?;
                self.parse_text()?;
            }
            _ if super::expr::word_class(k) == super::expr::WordClass::Color => {
                self.parse_color()?;
                self.warn("Quick color belongs in texture. Color ignored.");
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Changes the top layer of an object's cover; the first change makes a copy of the default one.
    fn change_top_layer(
        &mut self,
        o: &mut Object,
        change: impl FnOnce(&mut Self, &mut crate::scene::TextureLayer) -> PResult<()>,
    ) -> PResult<()> {
        let mut texture = o.texture.take().unwrap_or_else(|| self.defaults.texture());
        let Texture::Layers(layers) = Arc::make_mut(&mut texture) else {
            return Err(self.error("Cannot change the pigment, normal or finish of a patterned texture."));
        };
        change(self, layers.last_mut().expect("a plain texture has a layer"))?;
        o.texture = Some(texture);
        Ok(())
    }

    /// Old words of a finish move to the object's interior.
    fn apply_extras(&mut self, o: &mut Object, extras: FinishExtras) {
        if extras == FinishExtras::default() {
            return;
        }
        let mut interior = o.interior.take().map_or_else(Interior::default, |i| (*i).clone());
        interior.ior = extras.ior.unwrap_or(interior.ior);
        interior.caustics = extras.caustics.unwrap_or(interior.caustics);
        interior.old_refraction = extras.refraction.unwrap_or(interior.old_refraction);
        o.interior = Some(Arc::new(interior));
    }

    /// `{ ... }` after `clipped_by` or `bounded_by`; `linked` is set once one of them is said to be the other, which ends both.
    fn clip_or_bound(&mut self, o: &mut Object, clip: bool, linked: &mut bool) -> PResult<()> {
        let (word, other) = if clip { ("clipped_by", Kw::BoundedBy) } else { ("bounded_by", Kw::ClippedBy) };
        if *linked {
            let what = if clip { "clips" } else { "bounds" };
            return Err(self.error(format!("Cannot add {what} after linking bounds and clips.")));
        }
        self.block(word, |p| {
            if p.accept_kw(other)? {
                *linked = true;
                if clip {
                    o.clipped_by = o.bounded_by.clone();
                } else {
                    o.bounded_by = o.clipped_by.clone();
                }
                return Ok(());
            }
            let list = if clip { &mut o.clipped_by } else { &mut o.bounded_by };
            let before = list.len();
            let mut object = p.need_object()?;
            loop {
                if object.texture.is_some() || object.interior_texture.is_some() || is_patch(&object.shape) {
                    return Err(p.error("Illegal texture or patch in clip, bound or object pattern."));
                }
                list.push(object);
                match p.parse_object()? {
                    Some(next) => object = next,
                    None => break,
                }
            }
            while let Some(t) = p.parse_transform()? {
                list[before..].iter_mut().for_each(|o| o.apply_transform(&t));
            }
            Ok(())
        })
    }

    /// `{ ... }` after an object's `photons`.
    pub(super) fn object_photons(&mut self, f: &mut PhotonFlags) -> PResult<()> {
        self.block("photons", |p| {
            while let Some(k) = p.peek_kw()? {
                match k {
                    Kw::Target => {
                        p.next()?;
                        f.target = Some(if p.number_follows()? { p.parse_float()? } else { 1.0 });
                    }
                    Kw::Reflection => {
                        p.next()?;
                        f.reflection = Some(p.parse_switch()?);
                    }
                    Kw::Refraction => {
                        p.next()?;
                        f.refraction = Some(p.parse_switch()?);
                    }
                    Kw::Collect => {
                        p.next()?;
                        f.collect = Some(p.parse_switch()?);
                    }
                    Kw::PassThrough => {
                        p.next()?;
                        f.pass_through = Some(p.parse_switch()?);
                    }
                    _ => break,
                }
            }
            Ok(())
        })
    }
}

/// A union, or the shared one of a declaration.
fn is_union(shape: &Shape) -> bool {
    match shape {
        Shape::Csg { op, .. } => *op == Csg::Union,
        Shape::Group { child } => is_union(&child.shape),
        _ => false,
    }
}

/// Shapes without an inside.
pub(super) fn is_patch(shape: &Shape) -> bool {
    match shape {
        Shape::Triangle { .. } | Shape::BicubicPatch { .. } | Shape::Polygon { .. } | Shape::Parametric { .. } => true,
        Shape::Mesh(m) => m.inside_vector.is_none(),
        _ => false,
    }
}

/// Shapes whose roots may be asked for more surely.
fn takes_sturm(shape: &Shape) -> bool {
    matches!(
        shape,
        Shape::Blob { .. }
            | Shape::Poly { .. }
            | Shape::Torus { .. }
            | Shape::Lathe { .. }
            | Shape::Sor { .. }
            | Shape::Prism { .. }
            | Shape::Ovus { .. }
    )
}

/// Number of terms of a polynomial of this order in x, y, z.
pub(super) fn poly_terms(order: u32) -> usize {
    let n = order as usize;
    (n + 1) * (n + 2) * (n + 3) / 6
}

fn is_object_word(k: Kw) -> bool {
    matches!(
        k,
        Kw::Sphere
            | Kw::Box
            | Kw::Cylinder
            | Kw::Cone
            | Kw::Plane
            | Kw::Torus
            | Kw::Disc
            | Kw::Triangle
            | Kw::SmoothTriangle
            | Kw::Polygon
            | Kw::Mesh
            | Kw::Mesh2
            | Kw::BicubicPatch
            | Kw::Quadric
            | Kw::Cubic
            | Kw::Quartic
            | Kw::Poly
            | Kw::Polynomial
            | Kw::Lathe
            | Kw::Sor
            | Kw::Prism
            | Kw::SphereSweep
            | Kw::Superellipsoid
            | Kw::Ovus
            | Kw::Blob
            | Kw::JuliaFractal
            | Kw::HeightField
            | Kw::Isosurface
            | Kw::Parametric
            | Kw::Text
            | Kw::Union
            | Kw::Merge
            | Kw::Intersection
            | Kw::Difference
            | Kw::Composite
            | Kw::Object
            | Kw::LightGroup
            | Kw::LightSource
    )
}
