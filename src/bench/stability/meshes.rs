//! Generated meshes, the same every time: closed ones, and such as trees have trouble with.

use crate::math::random::SplitMix64;
use crate::math::{DVec3, Vec3};
use std::collections::HashMap;

/// Triangles over shared vertices.
#[derive(Clone, Debug, Default)]
pub struct Triangles {
    /// Corners.
    pub vertices: Vec<Vec3>,
    /// Three corners each.
    pub faces: Vec<[u32; 3]>,
}

impl Triangles {
    /// Corners of a face.
    pub fn corners(&self, face: usize) -> [DVec3; 3] {
        self.faces[face].map(|v| self.vertices[v as usize].as_dvec3())
    }

    /// A face with corners of its own.
    pub fn add(&mut self, corners: [DVec3; 3]) {
        let base = self.vertices.len() as u32;
        self.vertices.extend(corners.map(|p| p.as_vec3()));
        self.faces.push([base, base + 1, base + 2]);
    }

    /// All faces of another.
    pub fn append(&mut self, other: &Triangles) {
        let base = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        self.faces.extend(other.faces.iter().map(|f| f.map(|v| v + base)));
    }

    /// With every corner moved.
    pub fn mapped(mut self, f: impl Fn(DVec3) -> DVec3) -> Self {
        self.vertices.iter_mut().for_each(|v| *v = f(v.as_dvec3()).as_vec3());
        self
    }

    /// Six faces of two triangles.
    pub fn add_box(&mut self, lo: DVec3, hi: DVec3) {
        let base = self.vertices.len() as u32;
        let pick = |k: u32, axis: usize| if k >> axis & 1 == 1 { hi[axis] } else { lo[axis] };
        self.vertices.extend((0..8).map(|k| DVec3::new(pick(k, 0), pick(k, 1), pick(k, 2)).as_vec3()));
        for [a, b, c, d] in [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]] {
            self.faces.push([a, b, c].map(|v: u32| v + base));
            self.faces.push([a, c, d].map(|v: u32| v + base));
        }
    }
}

/// Faces anywhere in -1..1, up to `size` large.
pub fn soup(n: usize, size: f64, seed: u64) -> Triangles {
    let (mut r, mut t) = (SplitMix64(seed), Triangles::default());
    for _ in 0..n {
        let (center, size) = (r.cube(), size * r.unit());
        t.add([center + size * r.cube(), center + size * r.cube(), center + size * r.cube()]);
    }
    t
}

/// A closed ball: an octahedron, or an icosahedron with `round`, halved `levels` times; 8 or 20 times 4^levels faces.
pub fn ball(levels: usize, round: bool, radius: f64) -> Triangles {
    let g = (1.0 + 5.0f64.sqrt()) / 2.0;
    let (mut points, mut faces): (Vec<DVec3>, Vec<[u32; 3]>) = if round {
        let p = [(-1.0, g), (1.0, g), (-1.0, -g), (1.0, -g)];
        let axes = |k: usize, a: f64, b: f64| [DVec3::new(a, b, 0.0), DVec3::new(0.0, a, b), DVec3::new(b, 0.0, a)][k];
        let points = (0..3).flat_map(|k| p.map(|(a, b)| axes(k, a, b).normalize())).collect();
        let f = [
            [0, 11, 5],
            [0, 5, 1],
            [0, 1, 7],
            [0, 7, 10],
            [0, 10, 11],
            [1, 5, 9],
            [5, 11, 4],
            [11, 10, 2],
            [10, 7, 6],
            [7, 1, 8],
            [3, 9, 4],
            [3, 4, 2],
            [3, 2, 6],
            [3, 6, 8],
            [3, 8, 9],
            [4, 9, 5],
            [2, 4, 11],
            [6, 2, 10],
            [8, 6, 7],
            [9, 8, 1],
        ];
        (points, f.to_vec())
    } else {
        let points = vec![DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
        (points, vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])
    };
    for _ in 0..levels {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                points.len() as u32 - 1
            })
        };
        let mut halved = Vec::with_capacity(faces.len() * 4);
        for [a, b, c] in faces {
            let [d, e, f] = [middle(a, b), middle(b, c), middle(c, a)];
            halved.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
        }
        faces = halved;
    }
    Triangles { vertices: points.iter().map(|p| (*p * radius).as_vec3()).collect(), faces }
}

/// Four faces around nothing in particular.
pub fn tetrahedron() -> Triangles {
    let vertices = vec![Vec3::new(1.0, 1.0, 1.0), Vec3::new(-1.0, -1.0, 1.0), Vec3::new(-1.0, 1.0, -1.0), Vec3::new(1.0, -1.0, -1.0)];
    Triangles { vertices, faces: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]] }
}

/// Squares of two triangles over (0..1)², bent by `at`.
pub fn grid(n: u32, at: impl Fn(f64, f64) -> DVec3) -> Triangles {
    let u = |i: u32| f64::from(i) / f64::from(n);
    let vertices = (0..=n).flat_map(|j| (0..=n).map(move |i| (u(i), u(j)))).map(|(a, b)| at(a, b).as_vec3()).collect();
    let mut faces = Vec::new();
    for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
        let [a, b, c, d] = [j * (n + 1) + i, j * (n + 1) + i + 1, (j + 1) * (n + 1) + i, (j + 1) * (n + 1) + i + 1];
        faces.extend([[a, b, c], [b, d, c]]);
    }
    Triangles { vertices, faces }
}

/// Hills, `2 n²` faces.
pub fn terrain(n: u32) -> Triangles {
    grid(n, |a, b| DVec3::new(4.0 * a - 2.0, 0.4 * (7.0 * a).sin() * (9.0 * b).cos(), 4.0 * b - 2.0))
}

/// All in the plane y = 0.3 (as the nearest `f32`), on a lattice.
pub fn flat(n: u32) -> Triangles {
    grid(n, |a, b| DVec3::new(2.0 * a - 1.0, 0.3, 2.0 * b - 1.0))
}

/// 1 to 10 long, 1e-6 to 1e-3 thick.
pub fn needles(n: usize) -> Triangles {
    let (mut r, mut t) = (SplitMix64(11), Triangles::default());
    for k in 0..n {
        let (from, along) = (r.cube() * 2.0, r.direction() * (1.0 + 9.0 * r.unit()));
        // Some run along an axis exactly.
        let along = if k % 4 == 0 { DVec3::AXES[k / 4 % 3] * along.length() } else { along };
        t.add([from, from + along, from + r.cube() * 10f64.powf(-3.0 - 3.0 * r.unit())]);
    }
    t
}

/// Far from the origin, where an `f32` step is 1/64 on an axis.
pub const FAR_AWAY: DVec3 = DVec3::new(148_376.0, 1_234.0, -223_423.0);

/// A tiny dense thing in a huge ring.
pub fn teapot_in_stadium() -> Triangles {
    let mut t = grid(8, |a, b| {
        let a = a * std::f64::consts::TAU;
        DVec3::new(1000.0 * a.cos(), 200.0 * b - 50.0, 1000.0 * a.sin())
    });
    t.append(&ball(1, true, 0.05).mapped(|p| p + DVec3::new(312.0, 0.5, -77.0)));
    t
}

/// Boxes in boxes, three faces of each in the planes of three faces of the others.
pub fn nested_boxes(n: usize) -> Triangles {
    let mut t = Triangles::default();
    (1..=n).for_each(|k| t.add_box(DVec3::ZERO, DVec3::splat(k as f64 / 8.0)));
    t.add_box(DVec3::splat(0.5), DVec3::splat(1.0));
    t
}
