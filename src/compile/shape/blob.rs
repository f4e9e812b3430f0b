//! Blobs as lists of field elements. Source: spec/objects.md, section 4.

use crate::accel::{Accel, AccelKind, AccelOptions, PrimSet};
use crate::math::{Bounds, DVec3, Transform};
use crate::scene::shape::{BlobComponent, BlobKind};

/// Form of an element's field, in the element's space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BlobElementKind {
    /// Distance from `center`.
    Sphere,
    /// Distance from `center`, only where (p - center)·axis is negative.
    HemisphereBelow,
    /// Distance from the axis through `center`, for `length` along `axis`.
    Cylinder {
        /// Length of the body.
        length: f64,
    },
}

/// One element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlobElement {
    /// Form.
    pub kind: BlobElementKind,
    /// Centre or start.
    pub center: DVec3,
    /// Unit; of cylinders and hemispheres.
    pub axis: DVec3,
    /// Squared reach.
    pub radius_sq: f64,
    /// The field is `f4` d⁴ + `f2` d² + `f0` for distance d.
    pub f4: f64,
    /// See `f4`.
    pub f2: f64,
    /// See `f4`: the strength.
    pub f0: f64,
    /// Blob space from element space, into [`BlobShape::transforms`], or `u32::MAX` for none.
    pub transform_ix: u32,
    /// Component that it belongs to.
    pub component: u32,
    /// Box of its reach in blob space.
    pub bounds: Bounds,
}

/// Elements in a group.
pub const GROUP: usize = 8;

/// A blob.
#[derive(Clone, Debug)]
pub struct BlobShape {
    /// The surface is where the field equals it.
    pub threshold: f64,
    /// Field elements.
    pub elements: Vec<BlobElement>,
    /// Boxes of the elements taken [`GROUP`] at a time: points pass most of a large blob by.
    pub groups: Vec<Bounds>,
    /// Tree over the elements' boxes, for rays.
    pub tree: Accel,
    /// Blob space from element space.
    pub transforms: Vec<Transform>,
    /// By component: own cover as index of `TextureTables::textures`, or `NONE`.
    pub textures: Vec<u32>,
    /// Box of all positive elements in blob space.
    pub bounds: Bounds,
    /// Roots by Sturm chains.
    pub sturm: bool,
}

/// The elements as a tree sees them.
struct ElementBoxes<'e>(&'e [BlobElement]);

impl PrimSet for ElementBoxes<'_> {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, k: usize) -> Bounds {
        self.0[k].bounds
    }
}

impl BlobShape {
    /// `None` when nothing has reach.
    pub fn new(threshold: f64, components: &[BlobComponent], textures: Vec<u32>, sturm: bool) -> Option<Self> {
        let (elements, groups, transforms, tree) = (Vec::new(), Vec::new(), Vec::new(), Accel::default());
        let mut shape = Self { threshold, elements, groups, tree, transforms, textures, bounds: Bounds::EMPTY, sturm };
        for (k, c) in components.iter().enumerate() {
            shape.add(k as u32, c);
        }
        let positive = shape.elements.iter().filter(|e| e.f0 > 0.0 || threshold < 0.0);
        shape.bounds = positive.fold(Bounds::EMPTY, |b, e| b.union(e.bounds));
        shape.groups = shape.elements.chunks(GROUP).map(|c| c.iter().fold(Bounds::EMPTY, |b, e| b.union(e.bounds))).collect();
        shape.tree = Accel::build(AccelKind::Auto, &ElementBoxes(&shape.elements), &AccelOptions::default());
        (!shape.bounds.is_empty()).then_some(shape)
    }

    fn add(&mut self, component: u32, c: &BlobComponent) {
        let transform_ix = if c.transform.is_identity() {
            u32::MAX
        } else {
            self.transforms.push(c.transform);
            self.transforms.len() as u32 - 1
        };
        let (BlobKind::Sphere { radius, .. } | BlobKind::Cylinder { radius, .. }) = c.kind;
        if radius == 0.0 || c.strength == 0.0 {
            return;
        }
        let r_sq = radius * radius;
        let mut push = |kind, center: DVec3, axis: DVec3, end: DVec3| {
            let reach = DVec3::splat(radius.abs());
            let ends = Bounds::from_corners(center, end);
            let local = Bounds { min: ends.min - reach, max: ends.max + reach };
            self.elements.push(BlobElement {
                kind,
                center,
                axis,
                radius_sq: r_sq,
                f4: c.strength / (r_sq * r_sq),
                f2: -2.0 * c.strength / r_sq,
                f0: c.strength,
                transform_ix,
                component,
                bounds: local.transformed(&c.transform),
            });
        };
        match c.kind {
            BlobKind::Sphere { center, .. } => push(BlobElementKind::Sphere, center, DVec3::Z, center),
            BlobKind::Cylinder { a, b, .. } => {
                let length = (b - a).length();
                let Some(axis) = (b - a).try_normalize() else {
                    return push(BlobElementKind::Sphere, a, DVec3::Z, a);
                };
                push(BlobElementKind::Cylinder { length }, a, axis, b);
                push(BlobElementKind::HemisphereBelow, a, axis, a);
                push(BlobElementKind::HemisphereBelow, b, -axis, b);
            }
        }
    }
}
