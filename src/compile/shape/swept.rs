//! Shapes made from curves: lathe, sor, prism, polygon, glyph.

use super::curve::{CurveSegment, closed_loops, open_curve, polygon_loops};
use crate::math::{Bounds, DVec2, DVec3, EPSILON};
use crate::scene::Shape;
use crate::scene::shape::{CurveKind, Glyph};

/// A curve (radius, y) turned about y.
#[derive(Clone, Debug, PartialEq)]
pub struct LatheShape {
    /// From the first point to the last.
    pub segments: Vec<CurveSegment>,
    /// Roots by Sturm chains.
    pub sturm: bool,
    /// Greatest radius.
    pub radius: f64,
    /// Least radius.
    pub inner_radius: f64,
    /// Lowest y.
    pub low: f64,
    /// Highest y.
    pub high: f64,
}

impl LatheShape {
    /// `None` without a segment.
    pub fn new(kind: CurveKind, points: &[DVec2], sturm: bool) -> Option<Self> {
        let segments = open_curve(kind, points);
        let (min, max) = extent(&segments)?;
        Some(Self { segments, sturm, radius: max.x.max(-min.x), inner_radius: min.x, low: min.y, high: max.y })
    }
}

/// A piece of a surface of revolution: radius² is a cubic in y between two heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SorSegment {
    /// Highest power first.
    pub c: [f64; 4],
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// A surface of revolution about y.
#[derive(Clone, Debug, PartialEq)]
pub struct SorShape {
    /// Upwards.
    pub segments: Vec<SorSegment>,
    /// Squared radii of the end discs, 0 for none.
    pub base_sq: f64,
    /// See `base_sq`.
    pub cap_sq: f64,
    /// Greatest radius.
    pub radius: f64,
    /// Roots by Sturm chains.
    pub sturm: bool,
}

impl SorShape {
    /// `None` with fewer than four points or heights that do not rise.
    pub fn new(points: &[DVec2], open: bool, sturm: bool) -> Option<Self> {
        let mut segments = Vec::new();
        let mut radius_sq = 0.0f64;
        for p in points.windows(4) {
            let (low, high) = (p[1].y, p[2].y);
            if high - low < EPSILON || (p[2].y - p[0].y).abs() < EPSILON || (p[3].y - p[1].y).abs() < EPSILON {
                return None;
            }
            let (v0, v1) = (p[1].x * p[1].x, p[2].x * p[2].x);
            let s0 = 2.0 * p[1].x * (p[2].x - p[0].x) / (p[2].y - p[0].y);
            let s1 = 2.0 * p[2].x * (p[3].x - p[1].x) / (p[3].y - p[1].y);
            // Hermite in h = y - low, then written out in y.
            let d = high - low;
            let a = (s0 + s1) / (d * d) - 2.0 * (v1 - v0) / (d * d * d);
            let b = 3.0 * (v1 - v0) / (d * d) - (2.0 * s0 + s1) / d;
            let m = -low;
            let c = [a, b + 3.0 * a * m, s0 + 2.0 * b * m + 3.0 * a * m * m, v0 + s0 * m + b * m * m + a * m * m * m];
            let c = c.map(|v| if v.abs() < EPSILON { 0.0 } else { v });
            let s = SorSegment { c, low, high };
            radius_sq = radius_sq.max(v0).max(v1);
            for y in crate::math::roots::solve_quadratic(3.0 * c[0], 2.0 * c[1], c[2]).iter() {
                if (low..=high).contains(y) {
                    radius_sq = radius_sq.max(s.radius_sq(*y));
                }
            }
            segments.push(s);
        }
        let (first, last) = (segments.first()?, segments.last()?);
        let disc = |r_sq: f64| if !open && r_sq > 1e-4 { r_sq } else { 0.0 };
        let (base_sq, cap_sq) = (disc(first.radius_sq(first.low)), disc(last.radius_sq(last.high)));
        Some(Self { base_sq, cap_sq, segments, radius: radius_sq.sqrt(), sturm })
    }

    /// Lowest and highest y.
    pub fn heights(&self) -> (f64, f64) {
        (self.segments.first().map_or(0.0, |s| s.low), self.segments.last().map_or(0.0, |s| s.high))
    }
}

impl SorSegment {
    /// Radius² at height `y`.
    #[inline]
    pub fn radius_sq(&self, y: f64) -> f64 {
        ((self.c[0] * y + self.c[1]) * y + self.c[2]) * y + self.c[3]
    }
}

/// A curve (x, z) moved along y.
#[derive(Clone, Debug, PartialEq)]
pub struct PrismShape {
    /// Closed loops.
    pub segments: Vec<CurveSegment>,
    /// The cross-section is scaled by y.
    pub conic: bool,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Without end faces.
    pub open: bool,
    /// Least x and z of the curve.
    pub min: DVec2,
    /// Greatest x and z of the curve.
    pub max: DVec2,
}

impl PrismShape {
    /// `None` when a curve does not close.
    pub fn new(shape: &Shape) -> Option<Self> {
        let Shape::Prism { kind, conic, low, high, points, open } = shape else { return None };
        let segments = closed_loops(*kind, points);
        let (min, max) = extent(&segments)?;
        Some(Self { segments, conic: *conic, low: low.min(*high), high: low.max(*high), open: *open, min, max })
    }

    /// Box in shape space.
    pub fn bounds(&self) -> Bounds {
        let at = |y: f64| {
            let s = if self.conic { y } else { 1.0 };
            Bounds::from_corners(DVec3::new(self.min.x * s, y, self.min.y * s), DVec3::new(self.max.x * s, y, self.max.y * s))
        };
        at(self.low).union(at(self.high))
    }
}

/// Flat loops in a plane of space.
#[derive(Clone, Debug, PartialEq)]
pub struct PolygonShape {
    /// First point.
    pub origin: DVec3,
    /// Unit, in the plane.
    pub u: DVec3,
    /// Unit, in the plane, perpendicular to `u`.
    pub v: DVec3,
    /// u x v.
    pub normal: DVec3,
    /// Closed loops in (u, v).
    pub segments: Vec<CurveSegment>,
}

impl PolygonShape {
    /// `None` when the points lie on a line or not in one plane.
    pub fn new(points: &[DVec3]) -> Option<Self> {
        let origin = *points.first()?;
        let u = points.iter().map(|p| *p - origin).find(|d| d.length() > EPSILON)?.normalize();
        let w = points.iter().map(|p| u.cross((*p - origin).normalize_or_zero())).find(|w| w.length() > EPSILON)?.normalize();
        let v = w.cross(u);
        if points.iter().any(|p| (*p - origin).dot(w).abs() > EPSILON * (1.0 + (*p - origin).length())) {
            return None;
        }
        let flat: Vec<DVec2> = points.iter().map(|p| DVec2::new((*p - origin).dot(u), (*p - origin).dot(v))).collect();
        Some(Self { origin, u, v, normal: w, segments: polygon_loops(&flat) })
    }
}

/// A letter from z = 0 to `depth`.
#[derive(Clone, Debug, PartialEq)]
pub struct GlyphShape {
    /// Closed loops.
    pub segments: Vec<CurveSegment>,
    /// Thickness.
    pub depth: f64,
    /// Least x and y.
    pub min: DVec2,
    /// Greatest x and y.
    pub max: DVec2,
}

impl GlyphShape {
    /// `None` for glyphs without outline (spaces).
    pub fn new(glyph: &Glyph, depth: f64) -> Option<Self> {
        let piece = |s: &[DVec2; 3]| {
            if s[1] == s[0] { CurveSegment::linear(s[0], s[2]) } else { CurveSegment::quadratic_bezier(s[0], s[1], s[2]) }
        };
        let segments: Vec<CurveSegment> = glyph.contours.iter().flatten().filter(|s| s[0] != s[2] || s[1] != s[0]).map(piece).collect();
        let (min, max) = extent(&segments)?;
        Some(Self { segments, depth, min, max })
    }

    /// Box in shape space.
    pub fn bounds(&self) -> Bounds {
        Bounds::from_corners(self.min.extend(0.0), self.max.extend(self.depth))
    }
}

fn extent(segments: &[CurveSegment]) -> Option<(DVec2, DVec2)> {
    let first = segments.first()?;
    Some(segments.iter().fold((first.min, first.max), |(a, b), s| (a.min(s.min), b.max(s.max))))
}
