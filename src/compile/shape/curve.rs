//! Plane curves of lathes and prisms, as cubic polynomials by segment; glyph outlines; the closed loops that they form.
//! Source: spec/objects.md, sections 5 and 8.

use crate::math::{DVec2, EPSILON};
use crate::scene::shape::CurveKind;

/// A piece of a curve: `c[0] w³ + c[1] w² + c[2] w + c[3]` for w in 0..=1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveSegment {
    /// Highest power first.
    pub c: [DVec2; 4],
    /// Highest power with a coefficient: 1..=3.
    pub degree: u8,
    /// Least coordinates on the segment.
    pub min: DVec2,
    /// Greatest coordinates on the segment.
    pub max: DVec2,
}

impl CurveSegment {
    fn new(c: [DVec2; 4], degree: u8) -> Self {
        let mut s = Self { c, degree, min: DVec2::INFINITY, max: DVec2::NEG_INFINITY };
        let mut include = |w: f64| {
            let p = s.c[3] + w * (s.c[2] + w * (s.c[1] + w * s.c[0]));
            (s.min, s.max) = (s.min.min(p), s.max.max(p));
        };
        include(0.0);
        include(1.0);
        for k in 0..2 {
            for w in crate::math::roots::solve_quadratic(3.0 * c[0][k], 2.0 * c[1][k], c[2][k]).iter() {
                if (0.0..=1.0).contains(w) {
                    include(*w);
                }
            }
        }
        s
    }

    /// Straight.
    pub fn linear(a: DVec2, b: DVec2) -> Self {
        Self::new([DVec2::ZERO, DVec2::ZERO, b - a, a], 1)
    }

    /// Bézier of degree two.
    pub fn quadratic_bezier(a: DVec2, control: DVec2, b: DVec2) -> Self {
        Self::new([DVec2::ZERO, a - 2.0 * control + b, 2.0 * (control - a), a], 2)
    }

    /// The point at `w`.
    #[inline]
    pub fn at(&self, w: f64) -> DVec2 {
        self.c[3] + w * (self.c[2] + w * (self.c[1] + w * self.c[0]))
    }

    /// The derivative at `w`.
    #[inline]
    pub fn slope(&self, w: f64) -> DVec2 {
        self.c[2] + w * (2.0 * self.c[1] + w * (3.0 * self.c[0]))
    }

    /// Calls `f` with every w in 0..=1 at which `a`·point + `b` is zero.
    #[inline]
    pub fn for_roots(&self, a: DVec2, b: f64, mut f: impl FnMut(f64)) {
        let c = self.c.map(|k| k.dot(a));
        let poly = [c[0], c[1], c[2], c[3] + b];
        if self.degree == 1 {
            if poly[2].abs() > 1e-300 {
                let w = -poly[3] / poly[2];
                if (0.0..=1.0).contains(&w) {
                    f(w);
                }
            }
            return;
        }
        let from = 3 - usize::from(self.degree);
        for w in crate::math::roots::solve_polynomial(&poly[from..], false, 0.0).iter() {
            if (0.0..=1.0).contains(w) {
                f(*w);
            }
        }
    }
}

fn quadratic(p: &[DVec2]) -> CurveSegment {
    CurveSegment::new([DVec2::ZERO, 0.5 * p[0] - p[1] + 0.5 * p[2], 0.5 * (p[2] - p[0]), p[1]], 2)
}

fn cubic(p: &[DVec2]) -> CurveSegment {
    CurveSegment::new(
        [-0.5 * p[0] + 1.5 * p[1] - 1.5 * p[2] + 0.5 * p[3], p[0] - 2.5 * p[1] + 2.0 * p[2] - 0.5 * p[3], 0.5 * (p[2] - p[0]), p[1]],
        3,
    )
}

fn bezier(p: &[DVec2]) -> CurveSegment {
    CurveSegment::new([p[3] - 3.0 * p[2] + 3.0 * p[1] - p[0], 3.0 * p[2] - 6.0 * p[1] + 3.0 * p[0], 3.0 * (p[1] - p[0]), p[0]], 3)
}

/// Segments of an open curve through `points` (lathe).
pub fn open_curve(kind: CurveKind, points: &[DVec2]) -> Vec<CurveSegment> {
    match kind {
        CurveKind::Linear => points.windows(2).map(|p| CurveSegment::linear(p[0], p[1])).collect(),
        CurveKind::Quadratic => points.windows(3).map(quadratic).collect(),
        CurveKind::Cubic => points.windows(4).map(cubic).collect(),
        CurveKind::Bezier => points.chunks_exact(4).map(bezier).collect(),
    }
}

fn same(a: DVec2, b: DVec2) -> bool {
    (a - b).abs().max_element() < EPSILON
}

/// Segments of closed loops through `points` (prism). Empty when a curve that must be closed is not.
pub fn closed_loops(kind: CurveKind, points: &[DVec2]) -> Vec<CurveSegment> {
    let mut out = Vec::new();
    let n = points.len();
    match kind {
        CurveKind::Linear => {
            let mut k = 0;
            while k < n {
                let first = points[k];
                let mut last = k;
                let mut closed = false;
                while last + 1 < n && !closed {
                    last += 1;
                    out.push(CurveSegment::linear(points[last - 1], points[last]));
                    closed = same(points[last], first);
                }
                if !closed && last > k {
                    out.push(CurveSegment::linear(points[last], first));
                }
                k = last + 1;
            }
        }
        CurveKind::Quadratic | CurveKind::Cubic => {
            // One control point, the loop until its first point comes again, and for cubic one more control point.
            let trail = usize::from(kind == CurveKind::Cubic);
            let mut k = 0;
            while k + 2 < n {
                let Some(last) = (k + 2..n - trail).find(|l| same(points[*l], points[k + 1])) else { return Vec::new() };
                for i in k + 1..last {
                    out.push(if trail == 1 { cubic(&points[i - 1..i + 3]) } else { quadratic(&points[i - 1..i + 2]) });
                }
                k = last + 1 + trail;
            }
        }
        CurveKind::Bezier => {
            let mut first: Option<DVec2> = None;
            for p in points.chunks_exact(4) {
                let start = *first.get_or_insert(p[0]);
                // Evaluated in the reverse direction.
                out.push(bezier(&[p[3], p[2], p[1], p[0]]));
                if same(p[3], start) {
                    first = None;
                }
            }
            if first.is_some() {
                return Vec::new();
            }
        }
    }
    out
}

/// Segments of polygon loops that close where their first point comes again, or at the end.
pub fn polygon_loops(points: &[DVec2]) -> Vec<CurveSegment> {
    closed_loops(CurveKind::Linear, points)
}

/// Even-odd rule over closed loops, counting crossings towards +x.
#[inline]
pub fn inside_loops(segments: &[CurveSegment], p: DVec2) -> bool {
    let mut inside = false;
    for s in segments {
        if p.y < s.min.y || p.y > s.max.y || p.x > s.max.x {
            continue;
        }
        if s.degree == 1 {
            let (a, d) = (s.c[3], s.c[2]);
            if (a.y >= p.y) != (a.y + d.y >= p.y) && a.x + d.x * (p.y - a.y) / d.y >= p.x {
                inside = !inside;
            }
        } else {
            // Ends belong to the segment whose other points near them lie above.
            s.for_roots(DVec2::Y, -p.y, |w| {
                let at_end = !(1e-9..=1.0 - 1e-9).contains(&w);
                let above = || s.at(if w < 0.5 { 1e-4 } else { 1.0 - 1e-4 }).y >= p.y;
                if (!at_end || above()) && s.at(w).x >= p.x {
                    inside = !inside;
                }
            });
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nested_loops_are_holes() {
        let square = |r: f64| [(-r, -r), (r, -r), (r, r), (-r, r), (-r, -r)].map(|(x, y)| DVec2::new(x, y));
        let points: Vec<DVec2> = square(2.0).into_iter().chain(square(1.0)).collect();
        let s = polygon_loops(&points);
        assert_eq!(s.len(), 8);
        assert!(!inside_loops(&s, DVec2::ZERO) && inside_loops(&s, DVec2::new(1.5, 0.0)) && !inside_loops(&s, DVec2::new(2.5, 0.0)));
    }

    #[test]
    fn curves_pass_through_their_points() {
        let p = [(0.0, 0.0), (1.0, 0.0), (2.0, 1.0), (2.5, 3.0)].map(|(x, y)| DVec2::new(x, y));
        let c = cubic(&p);
        assert_eq!((c.at(0.0), c.at(1.0)), (p[1], p[2]));
        let q = quadratic(&p);
        assert_eq!((q.at(0.0), q.at(1.0)), (p[1], p[2]));
        let b = bezier(&p);
        assert_eq!((b.at(0.0), b.at(1.0)), (p[0], p[3]));
        assert!((b.slope(0.0) - 3.0 * (p[1] - p[0])).length() < 1e-12);
    }

    #[test]
    fn open_cubic_prism_curve_disappears() {
        let p: Vec<DVec2> = (0..6).map(|k| DVec2::new(k as f64, (k * k) as f64)).collect();
        assert!(closed_loops(CurveKind::Cubic, &p).is_empty());
    }
}
