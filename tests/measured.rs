//! Patterns, pigments, functions, splines, normals and textures against numbers that POV-Ray printed or drew for them
//! (`tests/measured/*.txt`, written by `measure.py` there). Not for whole pictures: `pictures.rs` has those.

use rayloom::backend::{Backend, cpu::CpuBackend};
use rayloom::compile::{CompileOptions, compile_scene};
use rayloom::diag::{Sink, SourceMap};
use rayloom::film::Film;
use rayloom::integrate::RenderSettings;
use rayloom::kernel::query::KernelQuery;
use rayloom::lang::{LangOptions, Parsed, Stream, parse_scene};
use rayloom::world::DiskWorld;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/measured")
}

/// `kind: source` lines with the numbers below them, if any.
fn entries(text: &str) -> Vec<(&str, &str, Vec<&str>)> {
    let mut list: Vec<(&str, &str, Vec<&str>)> = Vec::new();
    for line in text.lines().filter(|l| !l.starts_with('#')) {
        match line.strip_prefix("  ") {
            Some(numbers) => {
                list.last_mut().expect("numbers follow an entry").2 = numbers.split([' ', ';']).filter(|w| !w.is_empty()).collect()
            }
            None => {
                let (kind, source) = line.split_once(": ").expect("entries are `kind: source`");
                list.push((kind, source, Vec::new()));
            }
        }
    }
    list
}

fn parse(text: &str, width: u32, height: u32) -> Parsed {
    let includes = PathBuf::from("/usr/share/povray-3.7/include");
    let world = DiskWorld { current_dir: folder(), library_paths: vec![includes], ..DiskWorld::default() };
    let (mut map, mut sink) = (SourceMap::default(), Sink::default());
    let options = LangOptions { width, height, ..LangOptions::default() };
    let parsed = parse_scene("measured.pov", text.as_bytes(), &world, &KernelQuery::new(), &options, &mut map, &mut sink);
    assert!(!sink.has_errors(), "{:?}", sink.items());
    parsed
}

fn near(ours: f64, povrays: f64, slack: f64) -> bool {
    ours == povrays || ours.is_nan() && povrays.is_nan() || (ours - povrays).abs() <= slack * (1.0 + povrays.abs())
}

/// What the standard include gives names to; its text stays where POV-Ray installs it.
fn declarations() -> String {
    let names = [
        "algbr_cyl1",
        "algbr_cyl2",
        "algbr_cyl3",
        "algbr_cyl4",
        "bicorn",
        "bifolia",
        "blob",
        "blob2",
        "boy_surface",
        "comma",
        "cross_ellipsoids",
        "crossed_trough",
        "cubic_saddle",
        "cushion",
        "devils_curve",
        "devils_curve_2d",
        "dupin_cyclid",
        "ellipsoid",
        "enneper",
        "flange_cover",
        "folium_surface",
        "folium_surface_2d",
        "glob",
        "heart",
        "helical_torus",
        "helix1",
        "helix2",
        "hex_x",
        "hex_y",
        "hetero_mf",
        "hunt_surface",
        "hyperbolic_torus",
        "isect_ellipsoids",
        "kampyle_of_eudoxus",
        "kampyle_of_eudoxus_2d",
        "klein_bottle",
        "kummer_surface_v1",
        "kummer_surface_v2",
        "lemniscate_of_gerono",
        "lemniscate_of_gerono_2d",
        "mesh1",
        "mitre",
        "nodal_cubic",
        "odd",
        "ovals_of_cassini",
        "paraboloid",
        "parabolic_torus",
        "ph",
        "pillow",
        "piriform",
        "piriform_2d",
        "poly4",
        "polytubes",
        "quantum",
        "quartic_paraboloid",
        "quartic_saddle",
        "quartic_cylinder",
        "r",
        "ridge",
        "ridged_mf",
        "rounded_box",
        "sphere",
        "spikes",
        "spikes_2d",
        "spiral",
        "steiners_roman",
        "strophoid",
        "strophoid_2d",
        "superellipsoid",
        "th",
        "torus",
        "torus2",
        "torus_gumdrop",
        "umbrella",
        "witch_of_agnesi",
        "witch_of_agnesi_2d",
        "noise3d",
    ];
    let mut text = String::new();
    for (n, name) in names.iter().enumerate() {
        text += &format!("#declare f_{name} = function {{ internal({n}) }}\n");
    }
    text += "#declare f_noise_generator = function { internal(78) }\n#declare f_snoise3d = function { 2*f_noise3d(x,y,z) - 1 }\n";
    for pattern in ["agate", "mandel 25", "spiral2 2", "waves", "brick"] {
        let name = pattern.split(' ').next().expect("a word");
        text += &format!("#declare f_{name} = function {{ pattern {{ {pattern} }} }}\n");
    }
    text += "#declare f_dents = function { pow(f_noise3d(x,y,z), 3) }\n#declare f_hexagon = function { pigment { hexagon rgb 0, rgb .5, rgb 1 } }\n";
    text
}

#[test]
fn patterns_pigments_functions_and_splines_are_povrays() {
    let text = std::fs::read_to_string(folder().join("values.txt")).expect("values.txt");
    let list = entries(&text);
    let points: Vec<Vec<&str>> = list.iter().filter(|e| e.0 == "at").map(|e| e.1.split(' ').collect()).collect();
    let mut scene = String::from("#version 3.7;\nglobal_settings { assumed_gamma 1 }\ncamera { location -z }\n");
    for (n, (kind, source, _)) in list.iter().enumerate() {
        let call = match *kind {
            "declare" if source.starts_with("#include") => {
                scene += &declarations();
                continue;
            }
            "declare" => {
                scene += &format!("{source}\n");
                continue;
            }
            "pattern" | "pigment" => {
                scene += &format!("#declare F{n} = function {{ {kind} {{ {source} }} }}\n");
                format!("F{n}(X,Y,Z)")
            }
            "function" => {
                scene += &format!("#declare F{n} = function {{ {source} }}\n");
                format!("F{n}(X,Y,Z)")
            }
            "value" => (*source).to_string(),
            _ => continue,
        };
        for p in &points {
            let [x, y, z] = p[..] else { panic!("points have three coordinates") };
            let call = call.replace('X', &format!("({x})")).replace('Y', &format!("({y})")).replace('Z', &format!("({z})"));
            if *kind == "pigment" {
                let parts = ["red", "green", "blue", "filter", "transmit"].map(|c| format!("str(C.{c},0,6)")).join(",\"/\",");
                scene += &format!("#declare C = {call}; #debug concat(\"{n} \",{parts},\"\\n\")\n");
            } else {
                scene += &format!("#debug concat(\"{n} \",str({call},0,12),\"\\n\")\n");
            }
        }
    }
    let mut ours = vec![Vec::new(); list.len()];
    let printed: String = parse(&scene, 4, 4).output.iter().filter(|o| o.0 == Stream::Debug).map(|o| o.1.as_str()).collect();
    for line in printed.lines() {
        if let Some((n, numbers)) = line.split_once(' ') {
            ours[n.parse::<usize>().expect("lines start with the entry's number")].push(numbers.to_string());
        }
    }
    let mut wrong = Vec::new();
    for ((kind, source, povrays), ours) in list.iter().zip(&ours) {
        assert_eq!(povrays.len(), ours.len(), "{kind}: {source}");
        // Colours are 32-bit numbers, and so are densities; a fractal far outside is chaos.
        let single = *kind == "pigment" || source.contains("density_file") || source.contains("pigment_pattern") || source.contains("PF(");
        let slack = if single || source.contains("image_pattern") { 2e-6 } else { 2e-9 };
        for (k, (a, b)) in ours.iter().zip(povrays).enumerate() {
            let agree = a
                .split('/')
                .zip(b.split('/'))
                .all(|(a, b)| near(a.parse().expect("our number"), b.parse().expect("POV-Ray's number"), slack));
            if !agree {
                wrong.push(format!("{kind}: {source} at {:?}: {a}, POV-Ray: {b}", points[k]));
            }
        }
    }
    assert!(wrong.is_empty(), "{} values differ:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn patterns_of_the_plane_are_povrays() {
    let text = std::fs::read_to_string(folder().join("plane.txt")).expect("plane.txt");
    let list = entries(&text);
    let mut scene = String::from("#version 3.7;\nglobal_settings { assumed_gamma 1 }\ncamera { location -z }\n");
    let mut expected = Vec::new();
    for (n, (_, source, numbers)) in list.iter().enumerate() {
        scene += &format!("#declare F{n} = function {{ pigment {{ {source} color_map {{ [0 rgb 0] [1 rgb 1] }} }} }}\n");
        for point in numbers.chunks(3) {
            let [x, z, value] = point else { panic!("x, z and value") };
            scene += &format!("#debug concat(str(F{n}({x}, 0, {z}).red, 0, 7), \"\\n\")\n");
            expected.push((*source, format!("({x}, {z})"), value.parse::<f64>().expect("POV-Ray's number")));
        }
    }
    let printed: String = parse(&scene, 4, 4).output.iter().filter(|o| o.0 == Stream::Debug).map(|o| o.1.as_str()).collect();
    assert_eq!(printed.lines().count(), expected.len());
    let ours = printed.lines().map(|l| l.trim().parse::<f64>().expect("our number"));
    let wrong: Vec<String> = ours
        .zip(&expected)
        .filter(|(ours, (_, _, povrays))| !near(*ours, *povrays, 1e-6))
        .map(|(ours, (source, at, povrays))| format!("{source} at {at}: {ours}, POV-Ray: {povrays}"))
        .collect();
    assert!(wrong.is_empty(), "{} values differ:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn normals_and_textures_are_povrays() {
    const SIZE: [u32; 2] = [40, 30];
    let text = std::fs::read_to_string(folder().join("surfaces.txt")).expect("surfaces.txt");
    let list = entries(&text);
    let pixel = |s: &str| s.split_once(' ').map(|(x, y)| (x.parse::<u32>().expect("column"), y.parse::<u32>().expect("row")));
    let pixels: Vec<(u32, u32)> = list.iter().filter(|e| e.0 == "pixel").filter_map(|e| pixel(e.1)).collect();
    let mut wrong = Vec::new();
    for (kind, source, povrays) in list.iter().filter(|e| e.0 != "pixel") {
        let cover =
            if *kind == "normal" { format!("pigment {{ rgb 1 }} normal {{ {source} }} finish {{ F }}") } else { (*source).to_string() };
        let parsed = parse(&format!("#include \"scene.inc\"\n#macro Cover() {cover} #end\nSubjects()\n"), SIZE[0], SIZE[1]);
        let scene = parsed.scene.expect("a scene");
        let compiled = compile_scene(&scene, &CompileOptions::default()).expect("a small scene compiles");
        for (k, (x, y)) in pixels.iter().enumerate() {
            let settings = RenderSettings { crop: [*x, *y, x + 1, y + 1], ..RenderSettings::plain(SIZE[0], SIZE[1]) };
            let mut film = Film::new(SIZE[0], SIZE[1]);
            CpuBackend::new(1).render(&compiled, &settings, &mut film, &(), &AtomicBool::new(false)).expect("renders");
            let ours = film.pixels[film.index(*x, *y)];
            let agree = (0..3).all(|c| {
                let b: f64 = povrays[3 * k + c].parse().expect("POV-Ray's number");
                (f64::from(ours[c].clamp(0.0, 1.0)) * 65535.0 - b).abs() <= 4.0
            });
            if !agree {
                let ours = [0, 1, 2].map(|c| (ours[c].clamp(0.0, 1.0) * 65535.0).round());
                wrong.push(format!("{kind}: {source} at ({x}, {y}): {ours:?}, POV-Ray: {:?}", &povrays[3 * k..3 * k + 3]));
            }
        }
    }
    assert!(wrong.is_empty(), "{} pixels differ:\n{}", wrong.len(), wrong.join("\n"));
}
