//! What OBJ and MTL say and what the scene then holds.

use crate::files::{Folder, material, mesh, png};
use rayloom::math::Vec3;
use rayloom::scene::material::{AlphaMode, Texels};

/// As Blender 4.5 writes a cube's side and a leaf, with all its keys.
const BLENDER_OBJ: &str = "# Blender 4.5.0\n# www.blender.org\nmtllib my scene.mtl\no Side\n\
    v -1.000000 0.000000 1.000000 1.0000 0.0000 0.5000\nv 1.000000 0.000000 1.000000 1.0000 0.0000 0.5000\n\
    v 1.000000 0.000000 -1.000000 1.0000 0.0000 0.5000\nv -1.000000 0.000000 -1.000000 1.0000 0.0000 0.5000\n\
    vn -0.0000 1.0000 -0.0000\nvt 0.000000 0.000000\nvt 1.000000 0.000000\nvt 1.000000 1.000000\nvt 0.000000 1.000000\n\
    s 0\nusemtl Brick wall.001\nf 1/1/1 2/2/1 3/3/1 4/4/1\no Leaf\nv 0 1 0\nv 1 1 0\nv 0 2 0\nvn 0 0 1\ns 1\nusemtl Leaf\n\
    f 5/1/2 6/2/2 7/4/2\nusemtl\nf 5//2 7//2 6//2\ng a b\nl 5 6\nl 6 7\n";

const BLENDER_MTL: &str = "# Blender 4.5.0 MTL File: 'x.blend'\n# www.blender.org\n\nnewmtl Brick wall.001\nKs 0.500000 0.500000 0.500000\n\
    Ke 0.000000 0.000000 0.000000\nNi 1.450000\nd 1.000000\nillum 2\nPr 0.300000\nPm 0.250000\nPs 0.000000\nPc 0.000000\nPcr 0.030000\n\
    aniso 0.000000\nanisor 0.000000\nmap_Kd -s 2.000000 2.000000 1.000000 brick wall.png\nmap_Bump -bm 0.500000 brick wall.png\n\
    map_Pr rough.png\n\nnewmtl Leaf\nKd 0.1 0.8 0.1\nKs 0.5 0.5 0.5\nKe 1.0 2.0 3.0\nNi 1.5\nillum 2\nmap_d leaf.png\nmap_refl gone.png\n";

fn blender() -> Folder {
    Folder::new()
        .with("x.obj", BLENDER_OBJ)
        .with("my scene.mtl", BLENDER_MTL)
        .with("brick wall.png", png(2, 1, |x, _| [200 * x as u8, 128, 255, 255]))
        .with("rough.png", png(1, 1, |_, _| [51, 51, 51, 255]))
        .with("leaf.png", png(2, 1, |x, _| [9, 9, 9, 255 * x as u8]))
}

#[test]
fn an_export_of_blender_loads_with_every_key() {
    let (scene, said) = blender().load("x.obj");
    let scene = scene.expect("loads");
    assert_eq!(scene.objects.len(), 3, "one mesh a material");
    let m = mesh(&scene, 1);
    assert_eq!((m.faces.len(), m.vertices.len(), m.uvs.len()), (2, 4, 4));
    assert_eq!(m.normals, [Vec3::Y]);
    assert!((m.colors[0][2] - 0.214).abs() < 1e-3 && m.colors[0][0] == 1.0, "vertex colours are sRGB: {:?}", m.colors[0]);
    for f in &m.faces {
        let [a, b, c] = f.map(|k| m.vertices[k as usize]);
        assert!((b - a).cross(c - a).y > 0.0);
    }
    let brick = material(&scene, 1);
    assert_eq!((brick.metallic, brick.ior, brick.specular, brick.normal_scale), (0.25, 1.45, 1.0, 0.5));
    assert_eq!((brick.base_color, brick.roughness, brick.alpha_mode), (Vec3::ONE, 1.0, AlphaMode::Opaque));
    let t = brick.base_color_texture.as_ref().expect("a picture with a space in its name");
    assert_eq!((t.srgb, t.uv_transform), (true, [[2.0, 0.0, 0.0], [0.0, -2.0, 1.0]]));
    assert!(!brick.normal_texture.as_ref().expect("normals").srgb);
    let orm = brick.metallic_roughness_texture.as_ref().expect("roughness");
    assert_eq!(orm.image.texels, Texels::Rgba8(vec![[255, 51, 255, 255]]));
    let leaf = material(&scene, 2);
    assert_eq!((leaf.alpha_mode, leaf.emission), (AlphaMode::Blend, Vec3::new(1.0, 2.0, 3.0)));
    let alpha = &leaf.alpha_texture.as_ref().expect("alpha").image.texels;
    assert_eq!(*alpha, Texels::Rgba8(vec![[255, 255, 255, 0], [255; 4]]));
    assert_eq!(material(&scene, 0).base_color, Vec3::splat(0.8), "an empty usemtl is a plain material");
    for what in ["points and lines", "map_refl", "no camera"] {
        assert_eq!(said.iter().filter(|s| s.contains(what)).count(), 1, "{what}: {said:?}");
    }
    assert_eq!(said.len(), 3, "{said:?}");
}

#[test]
fn missing_libraries_materials_and_pictures_are_notes() {
    let f = Folder::new()
        .with("x.obj", "mtllib gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl What\nf 1 2 3\n")
        .with("y.obj", "mtllib y.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl A\nf 1 2 3\n")
        .with("y.mtl", "newmtl A\nKd 1 0 0\nmap_Kd no\\where.png\n");
    let (scene, said) = f.load("x.obj");
    assert_eq!(scene.expect("loads").objects.len(), 1);
    assert!(said.iter().any(|s| s.contains("gone.mtl")) && said.iter().any(|s| s.contains("'What'")), "{said:?}");
    let (scene, said) = f.load("y.obj");
    assert_eq!(material(&scene.expect("loads"), 0).base_color, Vec3::X);
    assert!(said.iter().any(|s| s.contains("where.png")), "{said:?}");
}

#[test]
fn negative_indices_continued_lines_and_odd_statements_are_read() {
    let text = "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0 1.0\r\nvt 0.5\r\nf -3/-1 \\\r\n-2/-1 -1/-1\r\ncurv 1 2\r\nunknown 1\r\nunknown 2\r\n#MRGB x\r\nlod 3\r\n";
    let (scene, said) = Folder::new().with("x.obj", text).load("x.obj");
    let scene = scene.expect("loads");
    assert_eq!(mesh(&scene, 0).vertices, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(mesh(&scene, 0).uvs, [[0.5, 0.0]]);
    for what in ["'unknown'", "free-form", "'lod'"] {
        assert_eq!(said.iter().filter(|s| s.contains(what)).count(), 1, "{what}: {said:?}");
    }
}

#[test]
fn concave_polygons_are_cut_inside_their_outline() {
    // A U of 7 unit squares lying in y = 0.
    let outline = [(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)];
    let mut text: String = outline.iter().map(|(x, z)| format!("v {x} 0 {z}\n")).collect();
    text += "f 1 2 3 4 5 6 7 8\n";
    let scene = Folder::new().with("x.obj", text).scene("x.obj");
    let m = mesh(&scene, 0);
    let areas: Vec<f32> = m
        .faces
        .iter()
        .map(|f| {
            let [a, b, c] = f.map(|k| m.vertices[k as usize]);
            0.5 * (b - a).cross(c - a).y
        })
        .collect();
    assert_eq!(m.faces.len(), 6);
    assert!(areas.iter().all(|a| *a < 0.0) && (areas.iter().sum::<f32>() + 7.0).abs() < 1e-5, "{areas:?}");
}

#[test]
fn smoothing_groups_without_normals_are_smooth_within_themselves() {
    // Two sides of a roof over the edge 1-2.
    let roof = |s: &str| format!("v 0 0 0\nv 0 0 1\nv 1 -1 0\nv -1 -1 0\n{s}f 1 2 3\nf 2 1 4\n");
    let f = Folder::new()
        .with("smooth.obj", roof("s 1\n"))
        .with("off.obj", roof("s off\n"))
        .with("two.obj", roof("s 1\n").replace("f 2", "s 2\nf 2"));
    assert!(mesh(&f.scene("off.obj"), 0).normal_indices.is_empty());
    let scene = f.scene("smooth.obj");
    let m = mesh(&scene, 0);
    let at = |face: usize, vertex: u32| {
        let k = m.faces[face].iter().position(|v| *v == vertex).expect("a corner");
        m.normals[m.normal_indices[face][k] as usize]
    };
    assert!((at(0, 0) - Vec3::Y).length() < 1e-6 && at(0, 0) == at(1, 0), "the ridge is shared");
    assert!((at(0, 2) - Vec3::new(1.0, 1.0, 0.0).normalize()).length() < 1e-6);
    let scene = f.scene("two.obj");
    let m = mesh(&scene, 0);
    assert!(m.normals.iter().all(|n| n.x.abs() > 0.5), "{:?}", m.normals);
}

#[test]
fn glass_and_transparency_of_libraries() {
    let obj = "mtllib x.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl glass\nf 1 2 3\nusemtl veil\nf 1 2 3\nusemtl shiny\nf 1 2 3\n";
    let mtl = "newmtl glass\nKd 1 1 1\nd 0.2\nillum 7\nNi 1.33\nnewmtl veil\nTr 0.75\nnewmtl shiny\nNs 250\nKs 1 1 1\nNi 1.0\nillum 3\n";
    let scene = Folder::new().with("x.obj", obj).with("x.mtl", mtl).scene("x.obj");
    let glass = material(&scene, 0);
    assert!((glass.transmission - 0.8).abs() < 1e-6 && glass.alpha_mode == AlphaMode::Opaque);
    assert!((scene.objects[0].interior.as_ref().expect("an inside").ior - 1.33).abs() < 1e-6);
    assert_eq!((material(&scene, 1).alpha, material(&scene, 1).alpha_mode), (0.25, AlphaMode::Blend));
    let shiny = material(&scene, 2);
    assert_eq!((shiny.roughness, shiny.specular, shiny.ior), (0.5, 2.0, 1.5));
}

#[test]
fn grey_bump_maps_become_normals_that_lean_down_the_slope() {
    let obj = "mtllib x.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl m\nf 1/1 2/1 3/1\n";
    let f = Folder::new()
        .with("x.obj", obj)
        .with("x.mtl", "newmtl m\nmap_bump h.png\n")
        .with("h.png", png(8, 8, |x, _| [16 * x as u8, 16 * x as u8, 16 * x as u8, 255]));
    let scene = f.scene("x.obj");
    let Texels::Rgba16(list) = &material(&scene, 0).normal_texture.as_ref().expect("normals").image.texels else { panic!("16 bits") };
    let [x, y, z, _] = list[8 * 3 + 3].map(|v| f64::from(v) / 32767.5 - 1.0);
    assert!((x / z + 16.0 / 255.0).abs() < 1e-3 && y.abs() < 1e-4, "{x} {y} {z}");
}

/// Measured by hand: `cargo test --test import -- --ignored --nocapture million`.
#[test]
#[ignore = "timing, by hand"]
fn a_million_triangles_load_in_under_two_seconds() {
    use std::fmt::Write;
    let n = 708;
    let mut text = String::new();
    for y in 0..n {
        for x in 0..n {
            let _ = writeln!(text, "v {:.6} {:.6} {:.6}", x as f32 * 0.01, ((x * 7 + y * 3) % 11) as f32 * 0.001, y as f32 * 0.01);
            let _ = writeln!(text, "vn 0.0000 1.0000 0.0000");
        }
    }
    let mut faces = 0;
    for y in 1..n {
        for x in 1..n {
            let k = (y - 1) * n + x;
            let [a, b, c, d] = [k, k + 1, k + n + 1, k + n];
            let _ = writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}\nf {a}//{a} {c}//{c} {d}//{d}");
            faces += 2;
        }
    }
    let f = Folder::new().with("x.obj", &text);
    let start = std::time::Instant::now();
    let scene = f.scene("x.obj");
    let took = start.elapsed();
    println!("OBJ, {} MB, {faces} triangles: {took:?}", text.len() >> 20);
    assert!(faces >= 999_000 && mesh(&scene, 0).faces.len() >= faces - 1000);
    assert!(took.as_secs_f64() < 2.0, "{took:?}");
}

#[test]
fn the_largest_polygons_are_cut_in_bounded_time() {
    // A comb of 4,000 teeth: every second corner is concave.
    let n = 8000;
    let mut text: String = (0..n).map(|k| format!("v {} {} 0\n", k, if k % 2 == 0 { 1 } else { 1000 })).collect();
    text += &format!("v {n} 0 0\nv 0 0 0\nf");
    (1..=n + 2).for_each(|k| text += &format!(" {k}"));
    let start = std::time::Instant::now();
    let scene = Folder::new().with("x.obj", text).scene("x.obj");
    assert_eq!(mesh(&scene, 0).faces.len(), n);
    assert!(start.elapsed().as_secs() < 10, "{:?}", start.elapsed());
}
