//! Polygons → triangles, concave ones too.

use crate::math::{DVec3, Vec3};
use earcut::Earcut;
use earcut::utils3d::project3d_to_2d;

/// Cuts polygons; keeps its memory between them.
pub(super) struct Cutter {
    earcut: Earcut<f64>,
    points: Vec<[f64; 3]>,
    flat: Vec<[f64; 2]>,
    triangles: Vec<u32>,
}

impl Cutter {
    /// Nothing cut yet.
    pub fn new() -> Self {
        Self { earcut: Earcut::new(), points: Vec::new(), flat: Vec::new(), triangles: Vec::new() }
    }

    /// Triangles of the polygon with `corners`, as places in `corners`, turned as the polygon is; those without area are left out.
    pub fn cut(&mut self, corners: &[Vec3], mut triangle: impl FnMut([usize; 3])) {
        let area = |[a, b, c]: [usize; 3]| {
            let [a, b, c] = [a, b, c].map(|k| corners[k].as_dvec3());
            (b - a).cross(c - a)
        };
        let mut give = |t: [usize; 3]| {
            if area(t) != DVec3::ZERO {
                triangle(t);
            }
        };
        match corners.len() {
            0..3 => {}
            3 => give([0, 1, 2]),
            // A quad that bends the same way at both ends of a diagonal is cut there.
            4 if area([0, 1, 2]).dot(area([0, 2, 3])) > 0.0 => {
                give([0, 1, 2]);
                give([0, 2, 3]);
            }
            4 if area([1, 2, 3]).dot(area([1, 3, 0])) > 0.0 => {
                give([1, 2, 3]);
                give([1, 3, 0]);
            }
            n => {
                self.points.clear();
                self.points.extend(corners.iter().map(|p| p.as_dvec3().to_array()));
                self.triangles.clear();
                if project3d_to_2d(&self.points, n, &mut self.flat) {
                    self.earcut.earcut(self.flat.iter().copied(), &[], &mut self.triangles);
                }
                let normal = newell(corners);
                for t in self.triangles.chunks_exact(3) {
                    let t = [t[0] as usize, t[1] as usize, t[2] as usize];
                    give(if area(t).dot(normal) < 0.0 { [t[0], t[2], t[1]] } else { t });
                }
            }
        }
    }
}

/// Normal of a polygon, its length twice the area. Source: Newell's method (Sutherland et al. 1974).
fn newell(corners: &[Vec3]) -> DVec3 {
    let n = corners.len();
    let p = |k: usize| (corners[k % n] - corners[0]).as_dvec3();
    (0..n).fold(DVec3::ZERO, |sum, k| sum + p(k).cross(p(k + 1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles and the sum of their areas along the polygon's normal.
    fn cut(corners: &[Vec3]) -> (usize, f64) {
        let normal = newell(corners).normalize();
        let (mut n, mut area) = (0, 0.0);
        Cutter::new().cut(corners, |t| {
            n += 1;
            let [a, b, c] = t.map(|k| corners[k].as_dvec3());
            let own = 0.5 * (b - a).cross(c - a).dot(normal);
            assert!(own > 0.0, "{t:?} is turned over");
            area += own;
        });
        (n, area)
    }

    #[test]
    fn concave_polygons_keep_their_area_and_their_side() {
        // An L of area 3 in a slanted plane, both ways round.
        let (x, y) = (Vec3::new(0.6, 0.8, 0.0), Vec3::new(0.0, 0.0, 1.0));
        let mut l: Vec<Vec3> = [(0., 0.), (2., 0.), (2., 1.), (1., 1.), (1., 2.), (0., 2.)].map(|(a, b)| a * x + b * y).into();
        for _ in 0..2 {
            let (n, area) = cut(&l);
            assert_eq!(n, 4);
            assert!((area - 3.0).abs() < 1e-6, "{area}");
            l.reverse();
        }
    }

    #[test]
    fn arrow_shaped_quads_are_cut_at_their_notch() {
        let mut arrow = vec![Vec3::ZERO, Vec3::new(2.0, 1.0, 0.0), Vec3::new(0.0, 2.0, 0.0), Vec3::new(1.0, 1.0, 0.0)];
        for _ in 0..4 {
            let (n, area) = cut(&arrow);
            assert_eq!(n, 2);
            assert!((area - 1.0).abs() < 1e-6, "{arrow:?}: {area}");
            arrow.rotate_left(1);
        }
    }

    #[test]
    fn degenerate_polygons_give_nothing() {
        let line: Vec<Vec3> = (0..6).map(|k| Vec3::splat(k as f32)).collect();
        let mut n = 0;
        Cutter::new().cut(&line, |_| n += 1);
        Cutter::new().cut(&[Vec3::ONE; 5], |_| n += 1);
        assert_eq!(n, 0);
    }
}
