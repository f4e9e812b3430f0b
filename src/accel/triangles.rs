//! Triangles of an indexed mesh as primitives, clipped to cells exactly.

use super::{BoxF, HUGE, PrimSet};
use crate::math::{Bounds, DVec3, Vec3, Vec3A};

/// The faces of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct TrianglePrims<'a> {
    /// Corner points.
    pub vertices: &'a [Vec3],
    /// Corners of each face, all below `vertices.len()`.
    pub faces: &'a [[u32; 3]],
}

impl PrimSet for TrianglePrims<'_> {
    fn len(&self) -> usize {
        self.faces.len()
    }

    fn bounds(&self, prim_ix: usize) -> Bounds {
        let [a, b, c] = self.faces[prim_ix].map(|v| self.vertices[v as usize]);
        if !(a.is_finite() && b.is_finite() && c.is_finite()) {
            return Bounds::EMPTY;
        }
        Bounds { min: a.min(b).min(c).as_dvec3(), max: a.max(b).max(c).as_dvec3() }
    }

    #[inline]
    fn boxed(&self, prim_ix: usize) -> Option<BoxF> {
        let [a, b, c] = self.faces[prim_ix].map(|v| Vec3A::from(self.vertices[v as usize]));
        // 0 times what is not finite is NaN.
        if a * 0.0 + b * 0.0 + c * 0.0 != Vec3A::ZERO {
            return None;
        }
        let cut = Vec3A::splat(HUGE as f32);
        let (lo, hi) = (a.min(b).min(c).clamp(-cut, cut), a.max(b).max(c).clamp(-cut, cut));
        Some(BoxF { lo: lo.to_array(), hi: hi.to_array() })
    }

    fn clipped_bounds(&self, prim_ix: usize, cell: &Bounds) -> Bounds {
        clip_triangle(self.faces[prim_ix].map(|v| self.vertices[v as usize].as_dvec3()), cell)
    }
}

/// Box of the part of a triangle in `cell`, in double precision (errors of a few units in the last place, which traversal's slack covers).
/// Source: Sutherland, Hodgman 1974; Wald, Havran 2006 ("perfect splits").
pub fn clip_triangle(corners: [DVec3; 3], cell: &Bounds) -> Bounds {
    // A triangle cut by six planes has at most nine corners.
    let mut poly = [DVec3::ZERO; 10];
    let mut next = [DVec3::ZERO; 10];
    poly[..3].copy_from_slice(&corners);
    let mut n = 3;
    for axis in 0..3 {
        for (plane, sign) in [(cell.min[axis], 1.0), (cell.max[axis], -1.0)] {
            let height = |p: DVec3| (p[axis] - plane) * sign;
            if poly[..n].iter().all(|p| height(*p) >= 0.0) {
                continue;
            }
            let mut m = 0;
            let mut prev = poly[n - 1];
            let mut h_prev = height(prev);
            for p in &poly[..n] {
                let h = height(*p);
                if (h >= 0.0) != (h_prev >= 0.0) && m < 9 {
                    // From the end nearer the plane, so that the error stays small beside the edge.
                    let mut q = prev + (*p - prev) * (h_prev / (h_prev - h));
                    q[axis] = plane;
                    next[m] = q;
                    m += 1;
                }
                if h >= 0.0 && m < 10 {
                    next[m] = *p;
                    m += 1;
                }
                prev = *p;
                h_prev = h;
            }
            if m == 0 {
                return Bounds::EMPTY;
            }
            std::mem::swap(&mut poly, &mut next);
            n = m;
        }
    }
    Bounds::from_points(poly[..n].iter().copied()).intersection(*cell)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clipping_gives_the_box_of_the_part_inside() {
        let corners = [DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0), DVec3::new(0.0, 4.0, 0.0)];
        let cell = Bounds { min: DVec3::new(1.0, 1.0, -1.0), max: DVec3::new(9.0, 9.0, 1.0) };
        assert_eq!(clip_triangle(corners, &cell), Bounds { min: DVec3::new(1.0, 1.0, 0.0), max: DVec3::new(3.0, 3.0, 0.0) });
        let beyond = Bounds { min: DVec3::new(2.5, 2.5, -1.0), max: DVec3::splat(9.0) };
        assert!(clip_triangle(corners, &beyond).is_empty(), "the box of the triangle reaches the cell, the triangle does not");
    }
}
