//! Sphere sweeps and ovus. Source: spec/objects.md, sections 2 and 12.

use crate::math::roots::solve_quadratic;
use crate::math::{Bounds, DVec3};
use crate::scene::shape::SweepKind;

/// A piece of a sweep: centre and radius as polynomials of u in 0..=1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepSegment {
    /// Centre, highest power (3) first.
    pub center: [DVec3; 4],
    /// Radius, highest power (3) first.
    pub radius: [f64; 4],
    /// Highest power with a coefficient: 1 or 3.
    pub degree: u8,
    /// Box of all its spheres.
    pub bounds: Bounds,
}

impl SweepSegment {
    fn new(center: [DVec3; 4], radius: [f64; 4], degree: u8) -> Self {
        let mut s = Self { center, radius, degree, bounds: Bounds::EMPTY };
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                // center ± radius along an axis is a cubic: its ends and turning points.
                let c: [f64; 4] = std::array::from_fn(|k| center[k][axis] + side * radius[k]);
                let mut include = |u: f64| {
                    let v = c[3] + u * (c[2] + u * (c[1] + u * c[0]));
                    (min[axis], max[axis]) = (min[axis].min(v), max[axis].max(v));
                };
                include(0.0);
                include(1.0);
                for u in solve_quadratic(3.0 * c[0], 2.0 * c[1], c[2]).iter().filter(|u| (0.0..=1.0).contains(*u)) {
                    include(*u);
                }
            }
        }
        s.bounds = Bounds { min, max };
        s
    }

    /// Centre at `u`.
    #[inline]
    pub fn center_at(&self, u: f64) -> DVec3 {
        let c = &self.center;
        c[3] + u * (c[2] + u * (c[1] + u * c[0]))
    }

    /// Radius at `u`.
    #[inline]
    pub fn radius_at(&self, u: f64) -> f64 {
        let r = &self.radius;
        r[3] + u * (r[2] + u * (r[1] + u * r[0]))
    }
}

/// Spheres along a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct SphereSweepShape {
    /// Pieces in the order of the curve.
    pub segments: Vec<SweepSegment>,
    /// Box of all spheres.
    pub bounds: Bounds,
}

impl SphereSweepShape {
    /// `None` with too few spheres.
    pub fn new(kind: SweepKind, spheres: &[(DVec3, f64)]) -> Option<Self> {
        let segments: Vec<SweepSegment> = match kind {
            SweepKind::Linear => spheres
                .windows(2)
                .map(|s| {
                    let [(a, ra), (b, rb)] = [s[0], s[1]];
                    SweepSegment::new([DVec3::ZERO, DVec3::ZERO, b - a, a], [0.0, 0.0, rb - ra, ra], 1)
                })
                .collect(),
            SweepKind::Cubic | SweepKind::BSpline => {
                const CATMULL_ROM: [[f64; 4]; 4] =
                    [[-0.5, 1.5, -1.5, 0.5], [1.0, -2.5, 2.0, -0.5], [-0.5, 0.0, 0.5, 0.0], [0.0, 1.0, 0.0, 0.0]];
                const B_SPLINE: [[f64; 4]; 4] = [
                    [-1.0 / 6.0, 0.5, -0.5, 1.0 / 6.0],
                    [0.5, -1.0, 0.5, 0.0],
                    [-0.5, 0.0, 0.5, 0.0],
                    [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0, 0.0],
                ];
                let m = if kind == SweepKind::Cubic { &CATMULL_ROM } else { &B_SPLINE };
                let make = |s: &[(DVec3, f64)]| {
                    let center = m.map(|row| (0..4).fold(DVec3::ZERO, |v, k| v + row[k] * s[k].0));
                    let radius = m.map(|row| (0..4).map(|k| row[k] * s[k].1).sum());
                    SweepSegment::new(center, radius, 3)
                };
                spheres.windows(4).map(make).collect()
            }
        };
        let bounds = segments.iter().fold(Bounds::EMPTY, |b, s| b.union(s.bounds));
        (!segments.is_empty()).then_some(Self { segments, bounds })
    }
}

/// A bottom sphere about the origin and a top sphere about (0, bottom, 0), joined by a circle's arc turned about y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OvusShape {
    /// Radius of the bottom sphere.
    pub bottom: f64,
    /// Radius of the top sphere.
    pub top: f64,
    /// Radius of the arc.
    pub arc: f64,
    /// The arc's centre is this far beyond the axis.
    pub offset: f64,
    /// Height of the arc's centre.
    pub height: f64,
    /// The bottom sphere shows below.
    pub low_cut: f64,
    /// The top sphere shows above.
    pub high_cut: f64,
}

impl OvusShape {
    /// `None` for radii that make no egg; the parser turns top >= 2 bottom into a sphere.
    pub fn new(rb: f64, rt: f64) -> Option<Self> {
        let s = if rb > rt {
            let (arc, v) = (2.0 * rb, 2.0 * rt - rb - rt * rt / (2.0 * rb));
            let high_cut = (rb - v) * rt / (arc - rt) + rb;
            Self { bottom: rb, top: rt, arc, offset: (rb * rb - v * v).sqrt(), height: v, low_cut: -v, high_cut }
        } else {
            let (arc, v) = (2.0 * rt, -2.0 * rt + rb + 1.5 * rt * rt / rb);
            let offset = (rt * rt - (v - rb).powi(2)).sqrt();
            Self { bottom: rb, top: rt, arc, offset, height: v, low_cut: -v * rb / (arc - rb), high_cut: 2.0 * rb - v }
        };
        (s.offset.is_finite() && rb > 0.0 && rt > 0.0).then_some(s)
    }

    /// Box in shape space.
    pub fn bounds(&self) -> Bounds {
        let r = self.bottom.max(self.top).max(self.arc - self.offset);
        Bounds { min: DVec3::new(-r, -self.bottom, -r), max: DVec3::new(r, self.bottom + self.top, r) }
    }
}
