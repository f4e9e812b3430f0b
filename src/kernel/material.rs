//! Imported materials at a hit: pictures looked up, vertex colours, the normal map. What they do to light is the integrators' matter.
//! Source: glTF 2.0, section 3.9 and appendix B. Twin: `shaders/shared/material`.

use super::SurfaceHit;
use crate::compile::CompiledScene;
use crate::compile::geometry::{Geometry, PrimKind};
use crate::compile::shape::MeshShape;
use crate::math::{DVec2, DVec3, Rgb, Vec3};
use crate::scene::Principled;
use crate::scene::input::Picture;
use crate::scene::material::{AlphaMode, MaterialImage, MaterialTexture, Texels, Wrap};
use std::sync::LazyLock;

/// A material with its pictures looked up at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Albedo of the diffuse part, colour of the metal, tint of what is seen through.
    pub base: Rgb,
    /// Share of surface, 0..=1; the mode is applied.
    pub alpha: f32,
    /// 0..=1.
    pub metallic: f32,
    /// 0..=1, before squaring.
    pub roughness: f32,
    /// Radiance.
    pub emission: Rgb,
    /// 0..=1.
    pub transmission: f32,
    /// Reflectance along the normal.
    pub f0: Rgb,
}

/// Linear values of 8-bit sRGB. Source: IEC 61966-2-1.
static LINEAR_FROM_SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|k| linear_from_srgb(k as f32 / 255.0)));

/// Linear value of an sRGB-encoded one.
pub fn linear_from_srgb(v: f32) -> f32 {
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

fn texel(t: &MaterialTexture, srgb: bool, x: u32, y: u32) -> [f32; 4] {
    let MaterialImage { width, texels, .. } = &*t.image;
    let k = y as usize * *width as usize + x as usize;
    match texels {
        Texels::Rgba8(list) if srgb => {
            let c = list[k];
            let lut = &*LINEAR_FROM_SRGB;
            [lut[usize::from(c[0])], lut[usize::from(c[1])], lut[usize::from(c[2])], f32::from(c[3]) / 255.0]
        }
        Texels::Rgba8(list) => list[k].map(|v| f32::from(v) / 255.0),
        Texels::Rgba16(list) => {
            let c = list[k].map(|v| f32::from(v) / 65535.0);
            if srgb { [linear_from_srgb(c[0]), linear_from_srgb(c[1]), linear_from_srgb(c[2]), c[3]] } else { c }
        }
        Texels::RgbaF32(list) => list[k],
    }
}

/// Column or row `k` brought into `0..n`.
fn wrapped(k: i64, n: u32, wrap: Wrap) -> u32 {
    let n = i64::from(n);
    (match wrap {
        Wrap::Repeat => k.rem_euclid(n),
        Wrap::Clamp | Wrap::Clip => k.clamp(0, n - 1),
        Wrap::Mirror => {
            let m = k.rem_euclid(2 * n);
            if m < n { m } else { 2 * n - 1 - m }
        }
    }) as u32
}

/// Picture coordinates of mesh coordinates.
pub fn picture_uv(t: &MaterialTexture, uv: DVec2) -> DVec2 {
    let row = |r: [f32; 3]| f64::from(r[0]) * uv.x + f64::from(r[1]) * uv.y + f64::from(r[2]);
    DVec2::new(row(t.uv_transform[0]), row(t.uv_transform[1]))
}

/// Linear red, green, blue, alpha at mesh coordinates. Texel centres lie at half integers.
pub fn sample_texture(t: &MaterialTexture, uv: DVec2) -> [f32; 4] {
    sample_as(t, t.srgb, uv)
}

/// A picture of an input at mesh coordinates: linear red, green, blue, alpha, by the input's own rules.
pub fn sample_picture(p: &Picture, uv: DVec2) -> [f32; 4] {
    let t = &p.texture;
    let late = t.srgb && p.filter_encoded && !matches!(t.image.texels, Texels::RgbaF32(_));
    let mut c = sample_as(t, t.srgb && !late, uv);
    if p.premultiplied && c[3] > 0.0 && c[3] < 1.0 {
        (0..3).for_each(|k| c[k] /= c[3]);
    }
    if late { [linear_from_srgb(c[0]), linear_from_srgb(c[1]), linear_from_srgb(c[2]), c[3]] } else { c }
}

fn sample_as(t: &MaterialTexture, srgb: bool, uv: DVec2) -> [f32; 4] {
    let (w, h) = (t.image.width, t.image.height);
    // Beyond 2^24 pictures nothing can be told apart any more.
    let p = picture_uv(t, uv).clamp(DVec2::splat(-16_777_216.0), DVec2::splat(16_777_216.0));
    let (x, y) = (p.x * f64::from(w), p.y * f64::from(h));
    if !(x.is_finite() && y.is_finite()) {
        return [1.0; 4];
    }
    let clips = |k: i64, n: u32, wrap: Wrap| wrap == Wrap::Clip && !(0..i64::from(n)).contains(&k);
    let at = |x: i64, y: i64| {
        if clips(x, w, t.wrap[0]) || clips(y, h, t.wrap[1]) {
            return [0.0; 4];
        }
        texel(t, srgb, wrapped(x, w, t.wrap[0]), wrapped(y, h, t.wrap[1]))
    };
    if !t.linear {
        return at(x.floor() as i64, y.floor() as i64);
    }
    let (x, y) = (x - 0.5, y - 0.5);
    let (x0, y0) = (x.floor(), y.floor());
    let (fx, fy) = ((x - x0) as f32, (y - y0) as f32);
    let (x0, y0) = (x0 as i64, y0 as i64);
    let (a, b, c, d) = (at(x0, y0), at(x0 + 1, y0), at(x0, y0 + 1), at(x0 + 1, y0 + 1));
    std::array::from_fn(|k| (a[k] * (1.0 - fx) + b[k] * fx) * (1.0 - fy) + (c[k] * (1.0 - fx) + d[k] * fx) * fy)
}

/// Mean colour of a picture (about 4,096 texels of it): what a shining surface gives on the whole.
pub fn mean_color(t: &MaterialTexture) -> Rgb {
    let (w, h) = (t.image.width, t.image.height);
    let (nx, ny) = (w.min(64), h.min(64));
    let mut sum = Vec3::ZERO;
    for j in 0..ny {
        for i in 0..nx {
            let c = texel(
                t,
                t.srgb,
                (u64::from(i) * u64::from(w) / u64::from(nx)) as u32,
                (u64::from(j) * u64::from(h) / u64::from(ny)) as u32,
            );
            sum += Vec3::new(c[0], c[1], c[2]);
        }
    }
    sum / (nx * ny) as f32
}

/// The mesh of a hit, if it is one.
pub fn mesh_of<'g>(g: &'g Geometry, hit: &SurfaceHit) -> Option<&'g MeshShape> {
    let prim = &g.prims[hit.prim_ix as usize];
    (prim.kind == PrimKind::Mesh).then(|| &g.shapes.meshes[prim.shape_ix as usize])
}

/// Linear RGBA of the mesh's vertex colours at a hit; white without any.
pub fn vertex_color(g: &Geometry, hit: &SurfaceHit) -> [f32; 4] {
    let Some(mesh) = mesh_of(g, hit).map(|m| &m.mesh).filter(|m| !m.colors.is_empty()) else { return [1.0; 4] };
    let Some(face) = mesh.faces.get(hit.face_ix as usize) else { return [1.0; 4] };
    let c = face.map(|v| mesh.colors.get(v as usize).copied().unwrap_or([1.0; 4]));
    let (b1, b2) = (hit.barycentric.x as f32, hit.barycentric.y as f32);
    std::array::from_fn(|k| (1.0 - b1 - b2) * c[0][k] + b1 * c[1][k] + b2 * c[2][k])
}

/// Material `m` at a hit.
pub fn material_at(scene: &CompiledScene, m: &Principled, hit: &SurfaceHit) -> Material {
    let look = |t: &Option<MaterialTexture>| t.as_ref().map_or([1.0; 4], |t| sample_texture(t, hit.uv));
    let vertex = vertex_color(&scene.geometry, hit);
    let color = look(&m.base_color_texture);
    let base = m.base_color * Vec3::new(color[0] * vertex[0], color[1] * vertex[1], color[2] * vertex[2]);
    let coverage = m.alpha * color[3] * vertex[3] * look(&m.alpha_texture)[3];
    let alpha = match m.alpha_mode {
        AlphaMode::Opaque => 1.0,
        AlphaMode::Mask(cutoff) => f32::from(coverage >= cutoff),
        AlphaMode::Blend => coverage.clamp(0.0, 1.0),
    };
    let orm = look(&m.metallic_roughness_texture);
    let metallic = (m.metallic * orm[2]).clamp(0.0, 1.0);
    let glow = look(&m.emission_texture);
    let f = ((m.ior - 1.0) / (m.ior + 1.0)).powi(2);
    let dielectric = (f * m.specular_color).min(Vec3::ONE) * m.specular;
    Material {
        base,
        alpha,
        metallic,
        roughness: (m.roughness * orm[1]).clamp(0.0, 1.0),
        emission: m.emission * Vec3::new(glow[0], glow[1], glow[2]),
        transmission: (m.transmission * look(&m.transmission_texture)[0]).clamp(0.0, 1.0),
        f0: dielectric * (1.0 - metallic) + base * metallic,
    }
}

/// Two unit normals at a hit, both on the side that `dir` comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normals {
    /// Of the flat face.
    pub flat: DVec3,
    /// Smooth and bent by the normal map; turned so far that the viewer sees its front.
    pub shading: DVec3,
}

/// The normals of an imported surface seen along `dir` (unit).
pub fn normals_at(scene: &CompiledScene, m: &Principled, hit: &SurfaceHit, dir: DVec3) -> Normals {
    let g = &scene.geometry;
    let Some(mesh) = mesh_of(g, hit) else {
        let n = if hit.normal.dot(dir) > 0.0 { -hit.normal } else { hit.normal };
        return Normals { flat: n, shading: n };
    };
    let transform = &g.transforms[g.prims[hit.prim_ix as usize].transform_ix as usize];
    let [p0, p1, p2] = mesh.corners(hit.face_ix);
    // glTF's front: corners run counterclockwise, before any mirroring of the node.
    let front = transform.normal((p1 - p0).cross(p2 - p0)).try_normalize().unwrap_or(hit.normal);
    let is_smooth = mesh.is_smooth(hit.face_ix);
    let mut shading = if is_smooth { hit.normal } else { front };
    if let Some(t) = &m.normal_texture {
        shading = mapped_normal(t, m.normal_scale, mesh, hit, transform, shading).unwrap_or(shading);
    }
    let flat = if front.dot(dir) > 0.0 { -front } else { front };
    // A smooth normal belongs to the side of the face that it is nearer to.
    let outward = if is_smooth && hit.normal.dot(front) < 0.0 { -front } else { front };
    if outward.dot(flat) < 0.0 {
        shading = -shading;
    }
    Normals { flat, shading: facing(shading, flat, dir) }
}

/// `n` turned just so far that a viewer along `dir` sees its front.
fn facing(n: DVec3, flat: DVec3, dir: DVec3) -> DVec3 {
    const LEAST_COS: f64 = 1e-3;
    let cos = -n.dot(dir);
    if cos >= LEAST_COS {
        return n;
    }
    (n - (LEAST_COS - cos) * dir).try_normalize().unwrap_or(flat)
}

/// The normal that a normal map gives for the smooth normal `n`; `None` where the coordinates have no direction.
fn mapped_normal(
    t: &MaterialTexture,
    scale: f32,
    mesh: &MeshShape,
    hit: &SurfaceHit,
    transform: &crate::math::Transform,
    n: DVec3,
) -> Option<DVec3> {
    let ix = mesh.mesh.uv_indices.get(hit.face_ix as usize)?;
    let [p0, p1, p2] = mesh.corners(hit.face_ix);
    let uv = ix.map(|k| mesh.mesh.uvs.get(k as usize).map_or(DVec2::ZERO, |c| DVec2::new(c[0].into(), c[1].into())));
    let [c0, c1, c2] = uv.map(|c| picture_uv(t, c));
    let (e1, e2, d1, d2) = (p1 - p0, p2 - p0, c1 - c0, c2 - c0);
    let det = d1.x * d2.y - d1.y * d2.x;
    if det == 0.0 {
        return None;
    }
    let along_u = transform.vector((e1 * d2.y - e2 * d1.y) / det);
    // The picture's v runs down, the map's green up.
    let along_up = transform.vector((e1 * d2.x - e2 * d1.x) / det);
    let tangent = (along_u - n * n.dot(along_u)).try_normalize()?;
    let bitangent = n.cross(tangent);
    let bitangent = if bitangent.dot(along_up) < 0.0 { -bitangent } else { bitangent };
    let c = sample_texture(t, hit.uv).map(f64::from);
    let (x, y, z) = ((2.0 * c[0] - 1.0) * f64::from(scale), (2.0 * c[1] - 1.0) * f64::from(scale), 2.0 * c[2] - 1.0);
    (tangent * x + bitangent * y + n * z).try_normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    /// 2 x 1 texels: black, then white.
    fn halves(wrap: Wrap, linear: bool) -> MaterialTexture {
        let image = MaterialImage { width: 2, height: 1, texels: Texels::Rgba8(vec![[0, 0, 0, 255], [255, 255, 255, 0]]) };
        MaterialTexture {
            image: Arc::new(image),
            srgb: false,
            wrap: [wrap, Wrap::Clamp],
            linear,
            uv_transform: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        }
    }

    #[test]
    fn bilinear_filter_runs_between_texel_centres() {
        let t = halves(Wrap::Clamp, true);
        for (u, want) in [(0.0, 0.0), (0.25, 0.0), (0.5, 0.5), (0.625, 0.75), (0.75, 1.0), (1.0, 1.0), (9.0, 1.0)] {
            let got = sample_texture(&t, DVec2::new(u, 0.3));
            assert!((f64::from(got[0]) - want).abs() < 1e-6, "u {u}: {got:?}");
            assert!((f64::from(got[3]) - (1.0 - want)).abs() < 1e-6);
        }
    }

    #[test]
    fn wraps_repeat_mirror_and_clamp_as_gl_does() {
        let red = |wrap, u: f64| sample_texture(&halves(wrap, false), DVec2::new(u, 0.5))[0];
        assert_eq!([1.2, 1.7, -0.2].map(|u| red(Wrap::Repeat, u)), [0.0, 1.0, 1.0]);
        assert_eq!([1.2, 1.7, -0.2].map(|u| red(Wrap::Mirror, u)), [1.0, 0.0, 0.0]);
        assert_eq!([1.2, 1.7, -0.2].map(|u| red(Wrap::Clamp, u)), [1.0, 1.0, 0.0]);
        assert!((sample_texture(&halves(Wrap::Repeat, true), DVec2::new(0.0, 0.5))[0] - 0.5).abs() < 1e-6, "the seam is filtered");
    }

    #[test]
    fn srgb_is_decoded_before_filtering_and_alpha_never() {
        let image = MaterialImage { width: 1, height: 1, texels: Texels::Rgba8(vec![[188, 10, 255, 188]]) };
        let t = MaterialTexture { image: Arc::new(image), srgb: true, ..halves(Wrap::Repeat, true) };
        let c = sample_texture(&t, DVec2::ZERO);
        assert!((c[0] - 0.5029).abs() < 1e-3 && (c[1] - 10.0 / 255.0 / 12.92).abs() < 1e-6, "{c:?}");
        assert!((c[3] - 188.0 / 255.0).abs() < 1e-6);
    }

    #[test]
    fn normals_that_face_away_are_turned_to_the_rim() {
        let dir = DVec3::NEG_Z;
        let n = facing(DVec3::new(0.8, 0.0, -0.6), DVec3::Z, dir);
        assert!((n.length() - 1.0).abs() < 1e-12 && n.z > 0.0 && n.x > 0.99, "{n}");
        assert_eq!(facing(DVec3::Z, DVec3::Z, dir), DVec3::Z);
    }
}
