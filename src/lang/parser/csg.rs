//! Set operations, blobs and the algebraic surfaces. Source: spec/language.md, section 7; spec/objects.md, sections 3, 4 and 13.

use super::objects::poly_terms;
use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::token::{Punct, TokenKind};
use crate::math::{DVec3, Transform};
use crate::scene::shape::{BlobComponent, BlobKind, Container, JuliaFunction};
use crate::scene::{Csg, Object, Shape};

impl Parser<'_> {
    /// The children of a set operation.
    pub(super) fn parse_csg(&mut self, op: Csg) -> PResult<Object> {
        let mut children = Vec::new();
        while let Some(child) = self.parse_object()? {
            if op != Csg::Union && op != Csg::Merge && super::objects::is_patch(&child.shape) {
                self.warn("Patch objects not allowed in intersection.");
            }
            if children.len() >= self.options.max_objects {
                return Err(self.error(format!("A set has more than {} objects.", self.options.max_objects)));
            }
            children.push(child);
        }
        if children.len() < 2 {
            self.warn("Should have at least 2 objects in csg.");
        }
        Ok(Object::new(Shape::Csg { op, children }))
    }

    pub(super) fn parse_blob(&mut self) -> PResult<Object> {
        let mut threshold = 1.0;
        let mut components = Vec::new();
        while let Some(k) = self.peek_kw()? {
            match k {
                Kw::Threshold => {
                    self.next()?;
                    threshold = self.parse_float()?;
                }
                Kw::Sphere | Kw::Cylinder => {
                    self.next()?;
                    components.push(self.block(k.text(), |p| p.blob_element(k))?);
                }
                Kw::Component => {
                    self.next()?;
                    let strength = self.parse_float()?;
                    self.comma()?;
                    let radius = self.parse_float()?;
                    self.comma()?;
                    let center = self.parse_vector3()?;
                    components.push(BlobComponent {
                        kind: BlobKind::Sphere { center, radius },
                        strength,
                        transform: Transform::IDENTITY,
                        texture: None,
                    });
                }
                _ => break,
            }
        }
        if components.is_empty() {
            return Err(self.error("No components in a blob."));
        }
        Ok(Object::new(Shape::Blob { threshold, components }))
    }

    fn blob_element(&mut self, k: Kw) -> PResult<BlobComponent> {
        let a = self.parse_vector3()?;
        self.comma()?;
        let kind = if k == Kw::Sphere {
            BlobKind::Sphere { center: a, radius: self.parse_float()? }
        } else {
            let b = self.parse_vector3()?;
            self.comma()?;
            if (a - b).length() < crate::math::EPSILON {
                return Err(self.error("Degenerate cylindrical component in blob."));
            }
            BlobKind::Cylinder { a, b, radius: self.parse_float()? }
        };
        self.comma()?;
        self.accept_kw(Kw::Strength)?;
        let strength = self.parse_float()?;
        // The element's modifiers are an object's.
        let mut o = Object::new(Shape::Sphere { center: DVec3::ZERO, radius: 1.0 });
        self.cover_modifiers(&mut o)?;
        Ok(BlobComponent { kind, strength, transform: o.transform, texture: o.texture })
    }

    pub(super) fn parse_quadric(&mut self) -> PResult<Shape> {
        let mut c = [0.0; 10];
        for i in 0..3 {
            let v = self.parse_vector3()?;
            self.comma()?;
            c[3 * i..3 * i + 3].copy_from_slice(&v.to_array());
        }
        c[9] = self.parse_float()?;
        Ok(Shape::Quadric { coefficients: c })
    }

    pub(super) fn poly_order(&mut self) -> PResult<u32> {
        let order = self.parse_int()?;
        if !(2..=35).contains(&order) {
            return Err(self.error("Order of poly is out of range."));
        }
        self.comma()?;
        Ok(order as u32)
    }

    /// `<n numbers>`.
    pub(super) fn coefficients(&mut self, n: usize) -> PResult<Vec<f64>> {
        self.expect(Punct::Lt)?;
        let mut c = Vec::with_capacity(n);
        for i in 0..n {
            if i > 0 {
                self.comma()?;
            }
            c.push(self.parse_float()?);
        }
        self.expect(Punct::Gt)?;
        Ok(c)
    }

    pub(super) fn parse_polynomial(&mut self) -> PResult<Shape> {
        let order = self.poly_order()?;
        let mut coefficients = vec![0.0; poly_terms(order)];
        while self.accept_kw(Kw::Xyz)? {
            self.expect(Punct::LParen)?;
            let mut e = [0usize; 3];
            for (i, e) in e.iter_mut().enumerate() {
                if i > 0 {
                    self.comma()?;
                }
                *e = self.parse_int()?.clamp(0, 99) as usize;
            }
            self.expect(Punct::RParen)?;
            self.expect(Punct::Colon)?;
            let c = self.parse_float()?;
            self.comma()?;
            match term_index(order as usize, e) {
                Some(i) => coefficients[i] = c,
                None => return Err(self.error("The sum of a term's exponents is larger than the polynomial's order.")),
            }
        }
        Ok(Shape::Poly { order, coefficients })
    }

    pub(super) fn parse_julia_fractal(&mut self) -> PResult<Shape> {
        let c = self.parse_vector4()?;
        let (mut hypercomplex, mut function) = (false, JuliaFunction::Sqr);
        let (mut max_iteration, mut precision) = (20, 20.0);
        let (mut slice, mut slice_distance) = (crate::math::DVec4::W, 0.0);
        while let Some(k) = self.peek_kw()? {
            use JuliaFunction as J;
            let f = match k {
                Kw::Sqr => J::Sqr,
                Kw::Cube => J::Cube,
                Kw::Exp => J::Exp,
                Kw::Reciprocal => J::Reciprocal,
                Kw::Sin => J::Sin,
                Kw::Asin => J::Asin,
                Kw::Sinh => J::Sinh,
                Kw::Asinh => J::Asinh,
                Kw::Cos => J::Cos,
                Kw::Acos => J::Acos,
                Kw::Cosh => J::Cosh,
                Kw::Acosh => J::Acosh,
                Kw::Tan => J::Tan,
                Kw::Atan => J::Atan,
                Kw::Tanh => J::Tanh,
                Kw::Atanh => J::Atanh,
                Kw::Ln => J::Ln,
                _ => {
                    match k {
                        Kw::Pwr => {
                            self.next()?;
                            self.expect(Punct::LParen)?;
                            let x = self.parse_float()?;
                            self.comma()?;
                            let y = self.parse_float()?;
                            self.expect(Punct::RParen)?;
                            function = J::Pwr(x, y);
                        }
                        Kw::Quaternion | Kw::Hypercomplex => {
                            self.next()?;
                            hypercomplex = k == Kw::Hypercomplex;
                        }
                        Kw::MaxIteration => {
                            self.next()?;
                            let n = self.parse_int()?.max(1);
                            max_iteration = self.at_most(n, 1 << 20, "max_iteration")?;
                        }
                        Kw::Precision => {
                            self.next()?;
                            precision = self.parse_float()?.max(1.0);
                        }
                        Kw::Slice => {
                            self.next()?;
                            slice = self.parse_vector4()?;
                            self.comma()?;
                            slice_distance = self.parse_float()?;
                            if slice.w.abs() < crate::math::EPSILON {
                                return Err(self.error("Illegal slice: the fourth component of the normal must not be 0."));
                            }
                        }
                        _ => break,
                    }
                    continue;
                }
            };
            self.next()?;
            function = f;
        }
        if !hypercomplex && !matches!(function, JuliaFunction::Sqr | JuliaFunction::Cube) {
            return Err(self.error("Illegal function for a quaternion julia_fractal: only sqr and cube."));
        }
        Ok(Shape::JuliaFractal { c, hypercomplex, function, max_iteration, precision, slice, slice_distance })
    }

    fn parse_container(&mut self) -> PResult<Container> {
        self.block("contained_by", |p| {
            let k = p.next()?;
            match k.kind {
                TokenKind::Kw(Kw::Box) => p.block("box", |p| {
                    let a = p.parse_vector3()?;
                    p.comma()?;
                    let b = p.parse_vector3()?;
                    Ok(Container::Box { min: a.min(b), max: a.max(b) })
                }),
                TokenKind::Kw(Kw::Sphere) => p.block("sphere", |p| {
                    let center = p.parse_vector3()?;
                    p.comma()?;
                    Ok(Container::Sphere { center, radius: p.parse_float()? })
                }),
                _ => Err(p.expected_instead("box or sphere", k)),
            }
        })
    }

    pub(super) fn parse_isosurface(&mut self) -> PResult<Shape> {
        let function = self.parse_function_item(3)?;
        let mut container = Container::Box { min: DVec3::NEG_ONE, max: DVec3::ONE };
        let (mut threshold, mut accuracy, mut max_gradient) = (0.0, 0.001, 1.1);
        let (mut evaluate, mut open, mut max_trace) = (None, false, 1);
        while let Some(k) = self.peek_kw()? {
            match k {
                Kw::ContainedBy => {
                    self.next()?;
                    container = self.parse_container()?;
                }
                Kw::Threshold => {
                    self.next()?;
                    threshold = self.parse_float()?;
                }
                Kw::Accuracy => {
                    self.next()?;
                    accuracy = self.positive_or("accuracy", 0.001)?;
                }
                Kw::MaxGradient => {
                    self.next()?;
                    max_gradient = self.positive_or("max_gradient", 1.1)?;
                }
                Kw::Evaluate => {
                    self.next()?;
                    let mut e = [0.0; 3];
                    for (i, e) in e.iter_mut().enumerate() {
                        if i > 0 {
                            self.comma()?;
                        }
                        *e = self.parse_float()?;
                    }
                    evaluate = Some(e);
                }
                Kw::MaxTrace => {
                    self.next()?;
                    max_trace = self.parse_int()?.clamp(1, 10) as u32;
                }
                Kw::AllIntersections => {
                    self.next()?;
                    max_trace = 10;
                }
                Kw::Open => {
                    self.next()?;
                    open = true;
                }
                _ => break,
            }
        }
        Ok(Shape::Isosurface { function, container, threshold, accuracy, max_gradient, evaluate, open, max_trace })
    }

    fn positive_or(&mut self, what: &str, default: f64) -> PResult<f64> {
        let x = self.parse_float()?;
        if x > 0.0 {
            return Ok(x);
        }
        self.warn(format!("{what} must be positive: {default} is used."));
        Ok(default)
    }

    pub(super) fn parse_parametric(&mut self) -> PResult<Shape> {
        let x = self.parse_function_item(2)?;
        self.comma()?;
        let y = self.parse_function_item(2)?;
        self.comma()?;
        let z = self.parse_function_item(2)?;
        self.comma()?;
        let functions = [x, y, z];
        let min = self.parse_vector2()?;
        self.comma()?;
        let max = self.parse_vector2()?;
        let mut container = Container::Box { min: DVec3::NEG_ONE, max: DVec3::ONE };
        let (mut accuracy, mut max_gradient, mut precompute) = (0.001, 1.0, None);
        while let Some(k) = self.peek_kw()? {
            match k {
                Kw::ContainedBy => {
                    self.next()?;
                    container = self.parse_container()?;
                }
                Kw::Accuracy => {
                    self.next()?;
                    accuracy = self.positive_or("accuracy", 0.001)?;
                }
                Kw::MaxGradient => {
                    self.next()?;
                    max_gradient = self.positive_or("max_gradient", 1.0)?;
                }
                Kw::Precompute => {
                    self.next()?;
                    let n = self.parse_int()?;
                    if !(1..=20).contains(&n) {
                        return Err(self.error("Precompute: invalid depth"));
                    }
                    let n = n as u32;
                    let mut axes = [false; 3];
                    self.comma()?;
                    while let Some(k @ (Kw::X | Kw::Y | Kw::Z)) = self.peek_kw()? {
                        self.next()?;
                        axes[if k == Kw::X {
                            0
                        } else if k == Kw::Y {
                            1
                        } else {
                            2
                        }] = true;
                        self.comma()?;
                    }
                    precompute = Some((n, axes));
                }
                _ => break,
            }
        }
        Ok(Shape::Parametric { functions, min, max, container, accuracy, max_gradient, precompute })
    }
}

/// Place of x^i y^j z^k in the list: x's exponent falls, then y's, then z's.
fn term_index(order: usize, e: [usize; 3]) -> Option<usize> {
    let mut at = 0;
    for x in (0..=order).rev() {
        for y in (0..=order - x).rev() {
            for z in (0..=order - x - y).rev() {
                if [x, y, z] == e {
                    return Some(at);
                }
                at += 1;
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomial_terms_stand_in_povrays_order() {
        assert_eq!(term_index(3, [3, 0, 0]), Some(0));
        assert_eq!(term_index(3, [2, 0, 0]), Some(3));
        assert_eq!(term_index(3, [0, 0, 0]), Some(19));
        assert_eq!(term_index(3, [2, 1, 1]), None);
        assert_eq!(poly_terms(4), 35);
    }
}
