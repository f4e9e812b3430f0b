//! Lathes, surfaces of revolution, prisms, sphere sweeps, height fields. Source: spec/language.md, section 7; spec/objects.md, sections 5, 7, 12.

use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::math::DVec2;
use crate::scene::Shape;
use crate::scene::shape::{CurveKind, SweepKind};

/// Most points of a curve.
const MAX_POINTS: i64 = 1 << 24;

impl Parser<'_> {
    fn curve_kind(&mut self) -> PResult<Option<CurveKind>> {
        let kind = match self.peek_kw()? {
            Some(Kw::LinearSpline) => CurveKind::Linear,
            Some(Kw::QuadraticSpline) => CurveKind::Quadratic,
            Some(Kw::CubicSpline) => CurveKind::Cubic,
            Some(Kw::BezierSpline) => CurveKind::Bezier,
            _ => return Ok(None),
        };
        self.next()?;
        Ok(Some(kind))
    }

    fn point_count(&mut self) -> PResult<usize> {
        let n = self.parse_int()?;
        if !(0..=MAX_POINTS).contains(&n) {
            return Err(self.error("Illegal number of points."));
        }
        Ok(n as usize)
    }

    fn points(&mut self, n: usize) -> PResult<Vec<DVec2>> {
        let mut points = Vec::new();
        for _ in 0..n {
            self.comma()?;
            points.push(self.parse_vector2()?);
        }
        Ok(points)
    }

    pub(super) fn parse_lathe(&mut self) -> PResult<Shape> {
        let kind = self.curve_kind()?.unwrap_or(CurveKind::Linear);
        let n = self.point_count()?;
        let enough = match kind {
            CurveKind::Linear => n >= 2,
            CurveKind::Quadratic => n >= 3,
            CurveKind::Cubic => n >= 4,
            CurveKind::Bezier => n >= 4 && n % 4 == 0,
        };
        if !enough {
            return Err(self.error("Too few points in lathe."));
        }
        let points = self.points(n)?;
        let inner = match kind {
            CurveKind::Linear => &points[..],
            CurveKind::Bezier => &[],
            CurveKind::Quadratic => &points[1..],
            CurveKind::Cubic => &points[1..n - 1],
        };
        if inner.iter().any(|p| p.x < 0.0) {
            return Err(self.error("Incorrect point in lathe."));
        }
        Ok(Shape::Lathe { kind, points })
    }

    pub(super) fn parse_sor(&mut self) -> PResult<Shape> {
        let n = self.point_count()?;
        if n < 4 {
            return Err(self.error("Surface of revolution must have at least four points."));
        }
        let points = self.points(n)?;
        let ordered = points[1..n - 1].windows(2).all(|w| w[0].y < w[1].y);
        if !ordered || points[1..n - 1].iter().any(|p| p.x < 0.0) {
            return Err(self.error("Incorrect point in surface of revolution."));
        }
        let open = self.accept_kw(Kw::Open)?;
        Ok(Shape::Sor { points, open })
    }

    pub(super) fn parse_prism(&mut self) -> PResult<Shape> {
        let (mut kind, mut conic) = (CurveKind::Linear, false);
        loop {
            if let Some(k) = self.curve_kind()? {
                kind = k;
            } else if self.accept_kw(Kw::LinearSweep)? {
                conic = false;
            } else if self.accept_kw(Kw::ConicSweep)? {
                conic = true;
            } else {
                break;
            }
        }
        let a = self.parse_float()?;
        self.comma()?;
        let b = self.parse_float()?;
        self.comma()?;
        let n = self.point_count()?;
        let enough = match kind {
            CurveKind::Linear => n >= 3,
            CurveKind::Quadratic => n >= 5,
            CurveKind::Cubic => n >= 6,
            CurveKind::Bezier => n >= 4 && n % 4 == 0,
        };
        if !enough {
            return Err(self.error("Too few points in prism."));
        }
        let points = self.points(n)?;
        let open = self.accept_kw(Kw::Open)?;
        let closed = match kind {
            CurveKind::Linear => is_closed(&points),
            _ => true,
        };
        if !closed {
            self.warn("Linear prism not closed. Closing it.");
        }
        Ok(Shape::Prism { kind, conic, low: a.min(b), high: a.max(b), points, open })
    }

    /// An ovoid: positive radii.
    pub(super) fn parse_ovus(&mut self) -> PResult<Shape> {
        let bottom = self.parse_float()?;
        self.comma()?;
        let top = self.parse_float()?;
        if bottom < 0.0 || top < 0.0 {
            return Err(self.error("Both Ovus radii must be positive."));
        }
        if top >= 2.0 * bottom {
            self.warn("Possible Parse Error: Second radius of ovus should be less than twice the first one: it is a sphere.");
        }
        Ok(Shape::Ovus { bottom, top })
    }

    pub(super) fn parse_sphere_sweep(&mut self) -> PResult<Shape> {
        let kind = match self.peek_kw()? {
            Some(Kw::LinearSpline) => SweepKind::Linear,
            Some(Kw::CubicSpline) => SweepKind::Cubic,
            Some(Kw::BSpline) => SweepKind::BSpline,
            _ => return self.expected("linear_spline, cubic_spline, or b_spline"),
        };
        self.next()?;
        let n = self.point_count()?;
        if n < if kind == SweepKind::Linear { 2 } else { 4 } {
            return Err(self.error("Too few spheres in sphere_sweep."));
        }
        let mut spheres = Vec::new();
        for _ in 0..n {
            self.comma()?;
            let center = self.parse_vector3()?;
            self.comma()?;
            spheres.push((center, self.parse_float()?));
        }
        let tolerance = if self.accept_kw(Kw::Tolerance)? { self.parse_float()? } else { 1e-6 };
        Ok(Shape::SphereSweep { kind, spheres, tolerance })
    }

    pub(super) fn parse_height_field(&mut self) -> PResult<Shape> {
        let heights = self.parse_heights()?;
        let (mut water_level, mut smooth) = (0.0, false);
        loop {
            if self.accept_kw(Kw::WaterLevel)? {
                water_level = self.parse_float()?;
            } else if self.accept_kw(Kw::Smooth)? {
                smooth = self.parse_switch()?;
            } else {
                return Ok(Shape::HeightField { heights, water_level, smooth });
            }
        }
    }
}

/// Whether every part of a polygon returns to its first point.
fn is_closed(points: &[DVec2]) -> bool {
    let mut rest = points;
    while let Some((first, tail)) = rest.split_first() {
        let Some(end) = tail.iter().position(|p| (*p - *first).abs().max_element() < crate::math::EPSILON) else { return false };
        rest = &tail[end + 1..];
    }
    true
}
