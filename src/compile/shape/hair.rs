//! Hair ready to be hit: curve by curve cut into spline segments, with a tree over them.

use crate::accel::{Accel, AccelKind, AccelOptions, PrimSet};
use crate::math::{Bounds, DVec3};
use crate::scene::Curves;
use std::sync::Arc;

/// A piece of a curve: a cubic between two of its points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HairSegment {
    /// Bézier points in the space of the curves.
    pub points: [DVec3; 4],
    /// Radius at both ends.
    pub radii: [f64; 2],
    /// Which curve.
    pub curve: u32,
}

/// Many hairs.
#[derive(Clone, Debug)]
pub struct HairShape {
    /// Segments in the order of the curves.
    pub segments: Vec<HairSegment>,
    /// Over the segments.
    pub tree: Accel,
    /// Box of them all.
    pub bounds: Bounds,
}

struct Segments<'s>(&'s [HairSegment]);

impl PrimSet for Segments<'_> {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn bounds(&self, k: usize) -> Bounds {
        self.0[k].bounds()
    }
}

impl HairSegment {
    /// A box around it: the curve stays among its Bézier points.
    pub fn bounds(&self) -> Bounds {
        let b = Bounds::from_points(self.points);
        let r = DVec3::splat(self.radii[0].max(self.radii[1]) * (1.0 + 1e-6) + 1e-9);
        Bounds { min: b.min - r, max: b.max + r }
    }

    /// Point at `u`, 0..=1.
    pub fn at(&self, u: f64) -> DVec3 {
        let [a, b, c, d] = self.points;
        let v = 1.0 - u;
        a * (v * v * v) + b * (3.0 * v * v * u) + c * (3.0 * v * u * u) + d * (u * u * u)
    }

    /// Derivative at `u`; never zero where the ends differ.
    pub fn tangent(&self, u: f64) -> DVec3 {
        let [a, b, c, d] = self.points;
        let v = 1.0 - u;
        let t = (b - a) * (v * v) + (c - b) * (2.0 * v * u) + (d - c) * (u * u);
        if t.length_squared() > 1e-24 { t } else { d - a }
    }

    /// Radius at `u`.
    pub fn radius(&self, u: f64) -> f64 {
        self.radii[0] + (self.radii[1] - self.radii[0]) * u
    }
}

impl HairShape {
    /// Of curves; `None` without a segment or when the arrays do not fit together.
    pub fn new(curves: &Arc<Curves>, accel: AccelKind) -> Option<Self> {
        let c = &**curves;
        let mut segments = Vec::new();
        for (curve, ends) in c.starts.windows(2).enumerate() {
            let (first, end) = (ends[0] as usize, ends[1] as usize);
            let (points, radii) = (c.points.get(first..end)?, c.radii.get(first..end)?);
            let at = |k: usize| points[k].as_dvec3();
            for k in 0..points.len().saturating_sub(1) {
                // Catmull and Rom's spline; before the first and after the last point that point again.
                let (p0, p1, p2, p3) = (at(k.saturating_sub(1)), at(k), at(k + 1), at((k + 2).min(points.len() - 1)));
                segments.push(HairSegment {
                    points: [p1, p1 + (p2 - p0) / 6.0, p2 - (p3 - p1) / 6.0, p2],
                    radii: [radii[k].max(0.0).into(), radii[k + 1].max(0.0).into()],
                    curve: curve as u32,
                });
            }
        }
        segments.retain(|s| s.points.iter().all(|p| p.is_finite()) && s.radii[0].max(s.radii[1]) > 0.0);
        if segments.is_empty() {
            return None;
        }
        let bounds = segments.iter().fold(Bounds::EMPTY, |b, s| b.union(s.bounds()));
        let tree = Accel::build(accel, &Segments(&segments), &AccelOptions { intersect_cost: 4.0, ..AccelOptions::default() });
        Some(Self { segments, tree, bounds })
    }
}
