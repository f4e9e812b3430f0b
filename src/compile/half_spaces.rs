//! Boxes around what planes leave of boxes: leaves of a CSG whose siblings are planes that stand across no axis get boxes of the part of
//! their surface that those planes leave, and a plane's own box is that of its cut through what holds it.

use crate::math::{Bounds, DMat3, DVec3};

/// The points with `normal · p <= limit`.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfSpace {
    pub normal: DVec3,
    pub limit: f64,
}

impl HalfSpace {
    /// What lies on the other side; both share the plane.
    pub fn flipped(self) -> Self {
        Self { normal: -self.normal, limit: -self.limit }
    }
}

/// Most half-spaces that are looked at: corners are sought among all triples of planes.
pub(super) const MOST: usize = 6;
/// Slack of the boxes, as a share of the largest coordinate.
const SLACK: f64 = 1e-6;

/// A box around what half-spaces leave of a box; the box itself where that is not known.
pub(super) fn shrunk(b: Bounds, half_spaces: &[HalfSpace]) -> Bounds {
    if b.is_unbounded() || b.is_empty() || half_spaces.is_empty() {
        return b;
    }
    let slack = SLACK * (1.0 + b.min.abs().max(b.max.abs()).max_element());
    // The last ones are those of the nearest nodes; more would only make the box smaller.
    let planes: Vec<HalfSpace> = [DVec3::X, DVec3::Y, DVec3::Z]
        .into_iter()
        .flat_map(|n| [HalfSpace { normal: n, limit: b.max.dot(n) }, HalfSpace { normal: -n, limit: -b.min.dot(n) }])
        .chain(half_spaces.iter().rev().take(MOST).copied())
        .collect();
    let mut corners = Bounds::EMPTY;
    for i in 0..planes.len() {
        for j in i + 1..planes.len() {
            for k in j + 1..planes.len() {
                let [p, q, r] = [planes[i], planes[j], planes[k]];
                let m = DMat3::from_cols(p.normal, q.normal, r.normal).transpose();
                // Planes that are nearly parallel meet far away, or nowhere that matters: the other triples bound what they leave.
                if m.determinant().abs() < 1e-9 {
                    continue;
                }
                let corner = m.inverse() * DVec3::new(p.limit, q.limit, r.limit);
                if planes.iter().all(|s| s.normal.dot(corner) <= s.limit + slack) {
                    corners = corners.including(corner);
                }
            }
        }
    }
    if corners.is_empty() {
        return b;
    }
    let grown = Bounds { min: corners.min - 2.0 * slack, max: corners.max + 2.0 * slack };
    b.intersection(grown)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn half_space(x: f64, y: f64, z: f64, limit: f64) -> HalfSpace {
        let n = DVec3::new(x, y, z);
        HalfSpace { normal: n.normalize(), limit: limit / n.length() }
    }

    #[test]
    fn a_box_is_cut_to_what_half_spaces_leave() {
        let unit = Bounds { min: DVec3::ZERO, max: DVec3::ONE };
        let near = |got: Bounds, min: DVec3, max: DVec3| {
            assert!((got.min - min).abs().max_element() < 1e-5 && (got.max - max).abs().max_element() < 1e-5, "{got:?}");
        };
        // x + y <= 0.5 leaves a prism; with y >= 0.25 its upper half.
        near(shrunk(unit, &[half_space(1.0, 1.0, 0.0, 0.5)]), DVec3::ZERO, DVec3::new(0.5, 0.5, 1.0));
        let upper = [half_space(1.0, 1.0, 0.0, 0.5), half_space(0.0, -1.0, 0.0, -0.25)];
        near(shrunk(unit, &upper), DVec3::new(0.0, 0.25, 0.0), DVec3::new(0.25, 0.5, 1.0));
        // The plane x = y between x + y <= 1 and the box: a rectangle that stands on its diagonal.
        let plane = half_space(1.0, -1.0, 0.0, 0.0);
        near(shrunk(unit, &[half_space(1.0, 1.0, 0.0, 1.0), plane, plane.flipped()]), DVec3::ZERO, DVec3::new(0.5, 0.5, 1.0));
        // Three planes that meet inside the box.
        let tip = [half_space(1.0, 1.0, 0.0, 0.8), half_space(1.0, -1.0, 0.0, 0.0), half_space(-1.0, 0.0, 1.0, 0.0)];
        near(shrunk(unit, &tip), DVec3::ZERO, DVec3::new(0.4, 0.8, 0.4));
        assert_eq!(shrunk(unit, &[half_space(1.0, 0.0, 0.0, -5.0)]), unit, "where nothing is left the box stays");
    }

    #[test]
    fn random_points_that_stay_are_in_the_box() {
        let mut random = crate::math::random::SplitMix64(3);
        let b = Bounds { min: DVec3::new(-3.0, 10.0, -1.0), max: DVec3::new(5.0, 11.0, 0.5) };
        let mut smaller = 0;
        for _ in 0..300 {
            let spaces: Vec<HalfSpace> = (0..5)
                .map(|_| {
                    let (normal, at) = (random.direction(), b.center() + random.cube() * b.size() * 0.4);
                    HalfSpace { normal, limit: normal.dot(at) }
                })
                .collect();
            let got = shrunk(b, &spaces);
            smaller += usize::from(got.area() < 0.9 * b.area());
            for _ in 0..200 {
                let p = b.center() + 0.5 * random.cube() * b.size();
                let stays = spaces.iter().all(|s| s.normal.dot(p) <= s.limit);
                assert!(!stays || got.contains(p), "{p} of {got:?}");
            }
        }
        assert!(smaller > 100, "the boxes of {smaller} of 300 are much smaller");
    }
}
