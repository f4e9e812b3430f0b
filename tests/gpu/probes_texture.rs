//! Texture shaders against the kernel, through the encoder that renders use: every pattern, pigment, normal and texture of
//! `tests/measured`, at thousands of points. Pictures say that something broke; probes say what.

use crate::found;
use rayloom::backend::BackendError;
use rayloom::backend::gpu::probe::run_probe;
use rayloom::backend::gpu::shader::assemble;
use rayloom::backend::gpu::texture_buffers::{TextureRoots, TextureWords, encode_textures};
use rayloom::backend::gpu::{Gpu, GpuOptions};
use rayloom::compile::texture::{Layer, TextureNode};
use rayloom::compile::{CompileOptions, CompiledScene, NONE, compile_scene};
use rayloom::diag::{Sink, SourceMap};
use rayloom::kernel::PatternPoint;
use rayloom::kernel::normal::perturb_normal;
use rayloom::kernel::pigment::eval_pigment;
use rayloom::kernel::query::KernelQuery;
use rayloom::kernel::texture::for_texture_parts;
use rayloom::lang::{LangOptions, parse_scene};
use rayloom::math::{DVec2, DVec3};
use rayloom::scene::function::internal_args;
use rayloom::world::DiskWorld;
use std::path::PathBuf;

/// Fields that a probe reads for each point.
const N_INPUTS: usize = 6;

fn gpu() -> Option<Gpu> {
    found(Gpu::new(&GpuOptions { accept_software: true, ..GpuOptions::default() }))
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/measured")
}

/// Numbers of the built-in functions.
fn built_in() -> impl Iterator<Item = u32> {
    (0..100).filter(|n| internal_args(*n).is_some())
}

/// A scene of spheres with these covers, in their order.
fn scene_of(covers: &[String]) -> CompiledScene {
    let mut text = String::from(
        "#version 3.7;\nglobal_settings { assumed_gamma 1 }\ncamera { location -z }\n#declare F = finish { ambient 0 }\n\
         #declare PF = function { pigment { bozo scale .3 } }\n\
         #declare PAT = function { pattern { granite turbulence .3 scale 2 } }\n#declare G = function(x, y) { x*y - 2 }\n\
         #declare TF = function { transform { rotate <10, 20, 30> scale <1, 2, 3> translate 2 } }\n\
         #declare INT_NOISE = function { internal(76) }\n#declare INT_NOISE_3 = function { internal(78) }\n\
         #declare RIDGED = function { internal(59) }\n#declare HETERO = function { internal(29) }\n#declare RIDGE = function { internal(58) }\n\
         #declare BOX = function { internal(60) }\n#declare TORUS = function { internal(70) }\n#declare SPHERE = function { internal(61) }\n\
         #declare R = function { internal(57) }\n#declare TH = function { internal(69) }\n#declare PH = function { internal(47) }\n\
         #declare HELIX = function { internal(25) }\n\
         #declare MAPPED = function { pigment { gradient x warp { turbulence .2 } pigment_map { [0 bozo scale .3] [.5 rgb <.4, .2, .9>]\
         [1 average pigment_map { [1 granite] [2 checker rgb 0, rgb <1, 1, .5>] }] } } }\n\
         #declare ASKING = function { pattern { function { MAPPED(x, y, z).blue + x } } }\n\
         #declare GREYS = function { pattern { pigment_pattern { spherical color_map { [0 rgb <1, .5, 0>] [1 rgb 0] } scale 4 } } }\n",
    );
    for n in built_in() {
        text += &format!("#declare BUILT_IN_{n} = function {{ internal({n}) }}\n");
    }
    for cover in covers {
        text += &format!("sphere {{ 0, 1 {cover} }}\n");
    }
    let world = DiskWorld { current_dir: folder(), ..DiskWorld::default() };
    let (mut map, mut sink) = (SourceMap::default(), Sink::default());
    let options = LangOptions { width: 4, height: 4, ..LangOptions::default() };
    let parsed = parse_scene("probes.pov", text.as_bytes(), &world, &KernelQuery::new(), &options, &mut map, &mut sink);
    assert!(!sink.has_errors(), "{:?}", sink.items());
    compile_scene(parsed.scene.as_ref().expect("a scene"), &CompileOptions::default()).expect("compiles")
}

/// The texture of each sphere.
fn textures_of(scene: &CompiledScene) -> Vec<u32> {
    let g = &scene.geometry;
    let mut list: Vec<(u32, u32)> = g.prims.iter().map(|p| (p.object_ix, g.surfaces[p.surface_ix as usize].texture)).collect();
    list.sort_unstable();
    list.into_iter().map(|(_, t)| t).collect()
}

fn lowest_layer(scene: &CompiledScene, texture: u32) -> Layer {
    match scene.textures.textures[texture as usize] {
        TextureNode::Layers { start, .. } => scene.textures.layers[start as usize],
        _ => panic!("a plain texture"),
    }
}

/// Sources of the given kinds in a file of `tests/measured`, without what the GPU refuses: functions and objects.
fn measured(file: &str, kind: &str) -> Vec<String> {
    let text = std::fs::read_to_string(folder().join(file)).expect("a measured list");
    let refused = ["function", "object", "F(", "G(", "#"];
    text.lines()
        .filter_map(|l| l.strip_prefix(kind)?.strip_prefix(": "))
        .filter(|l| !refused.iter().any(|r| l.contains(r)))
        .map(str::to_owned)
        .collect()
}

/// Numbers of a plain generator, -1..1.
struct Draw(u32);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0 >> 8) / f64::from(1 << 23) - 1.0
    }

    fn vector(&mut self, size: f64) -> DVec3 {
        // 32-bit numbers, so that both sides see the same point.
        DVec3::from_array(std::array::from_fn(|_| f64::from((self.next() * size) as f32)))
    }

    fn unit(&mut self) -> DVec3 {
        self.vector(1.0).normalize().as_vec3().as_dvec3()
    }
}

/// A point with all that a texture may look at, and a normal to be bent.
fn point_of(draw: &mut Draw, k: usize) -> (PatternPoint, DVec3) {
    let point = match k % 8 {
        // Lattice points, half-lattice points, the neighbourhood of the origin, large coordinates.
        0 => (draw.vector(6.0)).round(),
        1 => (draw.vector(12.0)).round() / 2.0,
        2 => draw.vector(0.01),
        3 => draw.vector(100.0),
        4 | 5 => draw.vector(2.0),
        _ => draw.vector(12.0),
    };
    let uv = DVec2::new(draw.vector(2.0).x, draw.vector(2.0).y);
    (PatternPoint { point, uv, world: draw.vector(3.0), normal: draw.unit(), ray_dir: draw.unit() }, draw.unit())
}

fn inputs_of(record: u32, at: &PatternPoint, n: DVec3) -> [[f32; 4]; N_INPUTS] {
    let three = |v: DVec3, w: f32| [v.x as f32, v.y as f32, v.z as f32, w];
    [
        three(at.point, record as f32),
        [at.uv.x as f32, at.uv.y as f32, 0.0, 0.0],
        three(at.world, 0.0),
        three(at.normal, 0.0),
        three(at.ray_dir, 0.0),
        three(n, 0.0),
    ]
}

fn run(gpu: &Gpu, probe: &str, words: &TextureWords, inputs: &[[f32; 4]], per_input: usize) -> Vec<[f32; 4]> {
    let n = inputs.len() / N_INPUTS * per_input;
    run_probe(gpu, probe, &words.shader, &words.words, &words.image_words, inputs, n).expect("the probe runs")
}

/// Points around one, a few roundings of 32-bit numbers away.
fn around(p: DVec3) -> impl Iterator<Item = DVec3> {
    let step = 5e-7 * (1.0 + p.abs().max_element());
    (0..27).map(move |k| p + step * DVec3::new(f64::from(k % 3 - 1), f64::from(k / 3 % 3 - 1), f64::from(k / 9 - 1)))
}

/// How far a GPU's answer is from the kernel's at the point, or from all that the kernel gives a few roundings around it.
fn distance<const N: usize>(gpu: [f64; N], at: &PatternPoint, kernel: impl Fn(&PatternPoint) -> [f64; N]) -> f64 {
    let ours = kernel(at);
    let off = |k: usize, low: f64, high: f64| {
        if gpu[k].is_nan() && ours[k].is_nan() { 0.0 } else { (low - gpu[k]).max(gpu[k] - high).max(0.0) }
    };
    let first = (0..N).map(|k| off(k, ours[k], ours[k])).fold(0.0, f64::max);
    if first < 1e-4 {
        return first;
    }
    let (mut low, mut high) = (ours, ours);
    for point in around(at.point) {
        let beside = kernel(&PatternPoint { point, ..*at });
        for k in 0..N {
            (low[k], high[k]) = (low[k].min(beside[k]), high[k].max(beside[k]));
        }
    }
    (0..N).map(|k| off(k, low[k], high[k])).fold(0.0, f64::max)
}

/// Shares of points off by more than 1e-4, by source.
struct Report {
    lines: Vec<String>,
    worst: f64,
}

impl Report {
    fn new() -> Self {
        Self { lines: Vec::new(), worst: 0.0 }
    }

    fn add(&mut self, source: &str, distances: &[f64], allowed: f64) {
        let off = distances.iter().filter(|d| !(**d < 1e-4)).count() as f64 / distances.len() as f64;
        let most = distances.iter().copied().fold(0.0, f64::max);
        self.worst = self.worst.max(off);
        if off > allowed {
            self.lines.push(format!("{:.2} % of points off, by up to {most:.2e}: {source}", off * 100.0));
        }
    }

    fn check(&self) {
        println!("worst share of points off: {:.3} %", self.worst * 100.0);
        assert!(self.lines.is_empty(), "{}", self.lines.join("\n"));
    }
}

const N_POINTS: usize = 2000;
/// Sources that share a shader: software devices run all branches of it.
const CHUNK: usize = 10;

/// Runs pigments of `sources` on both machines.
fn compare_pigments(gpu: &Gpu, sources: &[String], spoil: impl Fn(&mut TextureWords)) -> Vec<Vec<f64>> {
    sources.chunks(CHUNK).flat_map(|s| compare_some_pigments(gpu, s, None, &spoil)).collect()
}

/// `most_written`: what their functions may weigh that are written out as WGSL; the others are interpreted.
fn compare_some_pigments(gpu: &Gpu, sources: &[String], most_written: Option<usize>, spoil: impl Fn(&mut TextureWords)) -> Vec<Vec<f64>> {
    let covers: Vec<String> = sources.iter().map(|s| format!("pigment {{ {s} }}")).collect();
    let scene = scene_of(&covers);
    let pigments: Vec<u32> = textures_of(&scene).iter().map(|t| lowest_layer(&scene, *t).pigment).collect();
    assert_eq!(pigments.len(), sources.len());
    let roots = TextureRoots { pigments: pigments.iter().copied().collect(), most_written, ..TextureRoots::default() };
    let mut words = encode_textures(&scene.textures, &roots, false).expect("everything here is known to the GPU");
    spoil(&mut words);
    let mut draw = Draw(1);
    let points: Vec<_> = (0..N_POINTS).map(|k| point_of(&mut draw, k)).collect();
    let mut distances = Vec::new();
    for pigment in &pigments {
        let inputs: Vec<_> = points.iter().flat_map(|(p, n)| inputs_of(words.pigments[*pigment as usize], p, *n)).collect();
        let out = run(gpu, "pigment", &words, &inputs, 2);
        let one = |((p, _), o): (&(PatternPoint, DVec3), &[[f32; 4]])| {
            let wide = |v: f32| f64::from(v);
            let answer = [o[0][0], o[0][1], o[0][2], o[0][3], o[1][0], o[1][1]].map(wide);
            distance(answer, p, |p| {
                let found = eval_pigment(&scene, *pigment, p);
                let [r, g, b, f, t] = found.map_or([1.0, 1.0, 1.0, 0.0, 1.0], |c| c.to_array()).map(wide);
                [r, g, b, f, t, f64::from(u8::from(found.is_some()))]
            })
        };
        distances.push(points.iter().zip(out.chunks(2)).map(one).collect());
    }
    distances
}

/// Share of points that may be off: what is chaotic at 32 bits.
fn allowed(source: &str) -> f64 {
    let any = |words: &[&str]| words.iter().any(|w| source.contains(w));
    if any(&["mandel", "julia", "magnet"]) {
        0.02
    } else if any(&["checker", "brick", "cells"]) {
        // Points just below a lattice plane belong to the cell above it.
        0.006
    } else {
        0.002
    }
}

#[test]
fn patterns_and_pigments_are_the_kernels() {
    let Some(gpu) = gpu() else { return };
    let lists = ["brick", "checker", "cubic", "hexagon", "square", "triangular"];
    let patterns = measured("values.txt", "pattern").into_iter().map(|s| {
        let map = if lists.iter().any(|l| s.starts_with(l)) { "" } else { " color_map { [0 rgb 0][1 rgb 1] }" };
        // Fractals give thousands, whose fraction 32 bits do not keep.
        let fractal = ["mandel", "julia", "magnet"].iter().any(|l| s.starts_with(l));
        s + map + if fractal { " frequency 0" } else { "" }
    });
    let sources: Vec<String> = patterns.chain(measured("values.txt", "pigment")).collect();
    let mut report = Report::new();
    for (source, distances) in sources.iter().zip(compare_pigments(&gpu, &sources, |_| ())) {
        report.add(source, &distances, allowed(source));
    }
    report.check();
}

/// Functions of all that user functions know.
fn function_sources() -> Vec<String> {
    let expressions = [
        "x*y + z - 1",
        "sin(3*x)*cos(y) + tan(z/9)",
        "sqrt(x*x + y*y) - abs(z) + mod(x, .7)",
        "pow(x, 3)/9 + pow(y, 2) - pow(abs(z) + 1, .3)",
        "asin(x/100) + acos(y/100) + atan2(z, x) + exp(-y*y) + ln(abs(x) + 1) + log(abs(z) + 2)",
        "select(x, y, z) + select(floor(y/5), 1, 2, 3) + max(x, y, z)/7 + min(x, z) + int(x) + ceil(y) + div(z, 3)",
        "(x > y) + (y <= z)*2 + (x > 0 & z > 0)*3 + (x = y)",
        "sinh(x/40) + cosh(y/40) + tanh(z) + asinh(x) + radians(y) + degrees(z)",
        "INT_NOISE(x, y, z) + INT_NOISE_3(x*3, y*3, z*3, 3)",
        "RIDGED(x, y, z, .7, 2.1, 4, .9, 1.2, 2) - HETERO(x, y, z, .7, 2.1, 3.5, .4, 2, 1) + RIDGE(x, y, z, 2, 3.5, .5, .6, .4, 2)",
        "BOX(x, y, z, .2, 1, 1.5, .8) + TORUS(x, y, z, 2, .5) + SPHERE(x, y, z, 1.5) + R(x, y, z) + TH(x, y, z) + PH(x, y, z)",
        "HELIX(x, y, z, 2, 3, .3, 1, 1, 1, 0)",
        "PF(x, y, z).red + PF(z, y, x).green*2",
        "PAT(x*2, y, z) + G(x, z)",
        "TF(x, y, z).x - TF(z, y, x).z",
        "sum(i, 1, 5, sin(i*x)/i) + prod(i, 1, 3, 1 + y/(i*100))",
        "MAPPED(x/3, y, z).red - MAPPED(y/3, z, x).green + MAPPED(x/20, y, z).blue",
        "ASKING(x, y, z) + GREYS(x, y, z)/2 - PAT(y, z, x)",
    ];
    expressions.iter().map(|e| format!("function {{ {e} }} color_map {{ [0 rgb 0][1 rgb 1] }} frequency 0")).collect()
}

#[test]
fn user_functions_are_the_kernels() {
    let Some(gpu) = gpu() else { return };
    // The last ones take renderers in software minutes to compile in this form.
    let mut sources = function_sources();
    sources.truncate(16);
    let mut report = Report::new();
    for (source, distances) in sources.iter().zip(compare_pigments(&gpu, &sources, |_| ())) {
        report.add(source, &distances, 0.01);
    }
    report.check();
}

/// Each of POV-Ray's built-in functions, with parameters that none of them minds.
#[test]
fn built_in_functions_are_the_kernels() {
    let Some(gpu) = gpu() else { return };
    let numbers: Vec<u32> = built_in().collect();
    let source = |n: &u32| {
        let args = ["x/5", "y/5", "z/5", "1.3", ".7", ".6", ".8", ".5", "1", "2", ".4", ".9", "1.1"];
        let call = format!("BUILT_IN_{n}({})", args[..internal_args(*n).expect("it is there")].join(", "));
        format!("function {{ .5 + .45*{call}/(1 + abs({call})) }} color_map {{ [0 rgb 0][1 rgb 1] }} frequency 0")
    };
    let mut report = Report::new();
    for (k, some) in numbers.chunks(CHUNK).enumerate() {
        let sources: Vec<String> = some.iter().map(source).collect();
        // Written out and interpreted, by turns.
        for (source, distances) in sources.iter().zip(compare_some_pigments(&gpu, &sources, (k % 2 == 1).then_some(0), |_| ())) {
            report.add(source, &distances, 0.01);
        }
    }
    report.check();
}

#[test]
fn user_functions_that_are_interpreted_are_the_kernels() {
    let Some(gpu) = gpu() else { return };
    let sources = function_sources();
    let n_written = std::cell::Cell::new(0);
    let count = |words: &mut TextureWords| n_written.set(words.shader.functions.matches("fn user_function_").count());
    let mut report = Report::new();
    for (source, distances) in sources.iter().zip(compare_some_pigments(&gpu, &sources, Some(0), count)) {
        report.add(source, &distances, 0.01);
    }
    assert_eq!(n_written.get(), 0);
    // Both kinds beside each other: those that are light enough are written out.
    for (source, distances) in sources.iter().zip(compare_some_pigments(&gpu, &sources[..10], Some(4), count)) {
        report.add(source, &distances, 0.01);
    }
    assert!((1..10).contains(&n_written.get()), "{} of ten are written out", n_written.get());
    report.check();
    let other = |words: &mut TextureWords| {
        words.shader.functions = words.shader.functions.replace("operand(operands >> 16u)", "operand((operands >> 16u) ^ 1u)")
    };
    let off = compare_some_pigments(&gpu, &sources[..2], Some(0), other);
    assert!(off.iter().flatten().any(|d| *d > 1e-2), "wrong operands must be seen");
}

/// Loops in scenes declare functions that differ in a few numbers: one text for all of them, with the numbers in a table.
#[test]
fn functions_that_differ_in_numbers_are_written_once_and_stay_the_kernels() {
    let Some(gpu) = gpu() else { return };
    let of = |e: String| format!("function {{ {e} }} color_map {{ [0 rgb 0][1 rgb 1] }} frequency 0");
    // No product is that of another place, which would be worked out once; some numbers are equal.
    let alike = (0..6).map(|k| of(format!("sin({}*x) + 0.5*cos(2*y - {k}/7) + f_noise3d(x, {k}.5*y, z)", 1 + k)));
    let equal = (0..3).map(|_| of("x*y + z - 1".to_owned()));
    let sources: Vec<String> = alike.chain(equal).map(|s| s.replace("f_noise3d", "INT_NOISE")).collect();
    let mut report = Report::new();
    let written = std::cell::Cell::new((0, 0));
    let count = |words: &mut TextureWords| {
        let text = &words.shader.functions;
        written.set((text.matches("fn alike_function_").count(), text.matches("fn user_function_").count()));
    };
    for (source, distances) in sources.iter().zip(compare_some_pigments(&gpu, &sources, None, count)) {
        report.add(source, &distances, allowed(source));
    }
    report.check();
    assert_eq!(written.get(), (1, 1));
    let shift = |words: &mut TextureWords| {
        words.shader.functions = words.shader.functions.replace("number(numbers_at + 0u)", "number(numbers_at + 1u)")
    };
    let off = compare_some_pigments(&gpu, &sources, None, shift);
    assert!(off.iter().flatten().any(|d| *d > 1e-2), "numbers from wrong places must be seen");
}

#[test]
fn a_wrong_noise_table_is_seen() {
    let Some(gpu) = gpu() else { return };
    let sources = ["bozo".to_owned(), "checker rgb 0, rgb 1".to_owned()];
    // Word 0 is none; the table begins behind it.
    let distances = compare_pigments(&gpu, &sources, |w| w.words[1 + 17] = 2f32.to_bits());
    assert!(distances[0].iter().any(|d| *d > 1e-2), "noise must differ");
    let off = distances[1].iter().filter(|d| **d > 1e-4).count();
    assert!(off < N_POINTS / 100, "patterns without noise must not: {off} points");
}

#[test]
fn normals_are_the_kernels() {
    let Some(gpu) = gpu() else { return };
    let mut report = Report::new();
    for sources in measured("surfaces.txt", "normal").chunks(CHUNK) {
        compare_normals(&gpu, sources, &mut report);
    }
    report.check();
}

fn compare_normals(gpu: &Gpu, sources: &[String], report: &mut Report) {
    let covers: Vec<String> = sources.iter().map(|s| format!("pigment {{ rgb 1 }} normal {{ {s} }}")).collect();
    let scene = scene_of(&covers);
    let normals: Vec<u32> = textures_of(&scene).iter().map(|t| lowest_layer(&scene, *t).normal).collect();
    let roots = TextureRoots { normals: normals.iter().copied().collect(), ..TextureRoots::default() };
    let words = encode_textures(&scene.textures, &roots, false).expect("everything here is known to the GPU");
    let mut draw = Draw(2);
    let points: Vec<_> = (0..N_POINTS).map(|k| point_of(&mut draw, k)).collect();
    for (source, normal) in sources.iter().zip(&normals) {
        let inputs: Vec<_> = points.iter().flat_map(|(p, n)| inputs_of(words.normals[*normal as usize], p, *n)).collect();
        let out = run(gpu, "normal", &words, &inputs, 1);
        let distances: Vec<f64> = points
            .iter()
            .zip(&out)
            .map(|((p, n), o)| {
                let answer = [o[0], o[1], o[2]].map(f64::from);
                let off = distance(answer, p, |p| perturb_normal(&scene, *normal, *n, p).to_array());
                // Slopes multiply what 32 bits leave out far from the origin.
                off / (p.point.abs().max_element() / 12.0).max(1.0)
            })
            .collect();
        report.add(source, &distances, 0.005);
    }
}

/// The plain textures that a point shows, as the classic integrator walks them.
fn leaves(scene: &CompiledScene, texture: u32, at: &PatternPoint, weight: f64, out: &mut Vec<[f64; 5]>) {
    match &scene.textures.textures[texture as usize] {
        TextureNode::Layers { start, .. } => {
            let finish = scene.textures.layers[*start as usize].finish;
            out.push([f64::from(finish), weight, at.point.x, at.point.y, at.point.z]);
        }
        TextureNode::Principled(_) => panic!("not in these scenes"),
        node => {
            let mut parts = Vec::new();
            let inner = for_texture_parts(scene, node, at, |t, share| parts.push((t, f64::from(share))));
            for (t, share) in parts {
                leaves(scene, t, &inner, weight * share, out);
            }
        }
    }
}

#[test]
fn textures_show_the_same_parts_in_the_same_order() {
    let Some(gpu) = gpu() else { return };
    let sources: Vec<String> = measured("surfaces.txt", "texture");
    // A finish of its own for each part tells them apart.
    let mut n = 0;
    let named = |s: &String| {
        let mut parts = s.split("finish{F");
        let mut text = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            n += 1;
            text += &format!("finish{{F ambient {} {part}", f64::from(n) / 4096.0);
        }
        text
    };
    let covers: Vec<String> = sources.iter().map(named).collect();
    let scene = scene_of(&covers);
    let textures = textures_of(&scene);
    let roots = TextureRoots { textures: textures.iter().copied().collect(), ..TextureRoots::default() };
    let words = encode_textures(&scene.textures, &roots, false).expect("everything here is known to the GPU");
    let mut draw = Draw(3);
    let points: Vec<_> = (0..N_POINTS).map(|k| point_of(&mut draw, k)).collect();
    let mut report = Report::new();
    for (source, texture) in sources.iter().zip(&textures) {
        let inputs: Vec<_> = points.iter().flat_map(|(p, n)| inputs_of(words.textures[*texture as usize], p, *n)).collect();
        let out = run(&gpu, "texture", &words, &inputs, 16);
        let distances: Vec<f64> = points
            .iter()
            .zip(out.chunks(16))
            .map(|((p, _), o)| {
                let theirs: Vec<[f64; 5]> = (0..8)
                    .filter(|k| o[2 * k][3] == 1.0)
                    .map(|k| [o[2 * k][2], o[2 * k][1], o[2 * k + 1][0], o[2 * k + 1][1], o[2 * k + 1][2]].map(f64::from))
                    .collect();
                let off = |p: &PatternPoint| {
                    let mut ours = Vec::new();
                    leaves(&scene, *texture, p, 1.0, &mut ours);
                    if ours.len() != theirs.len() {
                        return 1.0;
                    }
                    // Warped points grow with their size.
                    let one =
                        |(a, b): (&[f64; 5], &[f64; 5])| (0..5).map(|k| (a[k] - b[k]).abs() / a[k].abs().max(1.0)).fold(0.0, f64::max);
                    ours.iter().zip(&theirs).map(one).fold(0.0, f64::max)
                };
                let first = off(p);
                if first < 1e-4 { first } else { around(p.point).map(|point| off(&PatternPoint { point, ..*p })).fold(first, f64::min) }
            })
            .collect();
        report.add(source, &distances, 0.005);
    }
    report.check();
}

#[test]
fn lattice_points_belong_to_the_same_cells_as_on_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let sources: Vec<String> =
        ["checker rgb 0, rgb 1", "cells", "brick rgb 0, rgb 1", "hexagon rgb 0, rgb x, rgb y"].map(str::to_owned).to_vec();
    let covers: Vec<String> = sources.iter().map(|s| format!("pigment {{ {s} }}")).collect();
    let scene = scene_of(&covers);
    let pigments: Vec<u32> = textures_of(&scene).iter().map(|t| lowest_layer(&scene, *t).pigment).collect();
    let roots = TextureRoots { pigments: pigments.iter().copied().collect(), ..TextureRoots::default() };
    let words = encode_textures(&scene.textures, &roots, false).expect("known to the GPU");
    for (source, pigment) in sources.iter().zip(&pigments) {
        // Whole coordinates, exactly and a rounding below, as hits on the sides of boxes and planes have them.
        let points = (0..1000).map(|k| {
            let p = DVec3::new(f64::from(k % 10 - 5), f64::from(k / 10 % 10 - 5), f64::from(k / 100 - 5));
            PatternPoint { point: p, uv: DVec2::ZERO, world: p, normal: DVec3::Y, ray_dir: DVec3::X }
        });
        let points: Vec<PatternPoint> = points.collect();
        for below in [0.0, 1e-6] {
            let moved = |p: &PatternPoint| PatternPoint { point: p.point - DVec3::splat(below), ..*p };
            let inputs: Vec<_> = points.iter().flat_map(|p| inputs_of(words.pigments[*pigment as usize], &moved(p), DVec3::Y)).collect();
            let out = run(&gpu, "pigment", &words, &inputs, 2);
            if below > 0.0 && source.starts_with("hexagon") {
                continue;
            }
            for (p, o) in points.iter().zip(out.chunks(2)) {
                let ours = eval_pigment(&scene, *pigment, p).expect("there").to_array();
                assert!((0..3).all(|k| (ours[k] - o[0][k]).abs() < 1e-5), "{source} at {} less {below}: {ours:?} {:?}", p.point, o[0]);
            }
        }
    }
}

#[test]
fn every_pattern_alone_gives_a_shader_that_naga_accepts() {
    let all = measured("values.txt", "pattern");
    for source in &all {
        let scene = scene_of(&[format!("pigment {{ {source} }} normal {{ {source} }}")]);
        let roots = TextureRoots::of_scene(&scene);
        let words = encode_textures(&scene.textures, &roots, false).expect("known to the GPU");
        for probe in ["pigment", "normal", "texture"] {
            let text = assemble(&format!("probes/{probe}"), &words.shader).unwrap_or_else(|e| panic!("{source}: {e}"));
            let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|e| panic!("{source}: {}", e.emit_to_string(&text)));
            let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
            validator.validate(&module).unwrap_or_else(|e| panic!("{source}: {e:?}"));
        }
    }
}

#[test]
fn what_the_gpu_cannot_do_is_refused_by_name() {
    let nested = (0..30).fold("gradient x".to_owned(), |inner, _| format!("gradient y pigment_map {{ [0 {inner}] [1 rgb 1] }}"));
    let scene = scene_of(&[format!("pigment {{ {nested} }}")]);
    match encode_textures(&scene.textures, &TextureRoots::of_scene(&scene), false) {
        Err(BackendError::Unsupported(what)) => assert!(what.contains("nested more than 24 deep"), "{what}"),
        other => panic!("expected a refusal, got {:?}", other.map(|w| w.words.len())),
    }
}

#[test]
fn parts_that_are_not_asked_for_are_not_encoded() {
    let scene = scene_of(&["pigment { bozo }".to_owned(), "pigment { granite }".to_owned()]);
    let first = lowest_layer(&scene, textures_of(&scene)[0]).pigment;
    let roots = TextureRoots { pigments: [first].into(), ..TextureRoots::default() };
    let words = encode_textures(&scene.textures, &roots, false).expect("known");
    assert!(words.shader.features.contains("pattern_bozo") && !words.shader.features.contains("pattern_granite"));
    assert_eq!(words.pigments.iter().filter(|at| **at != 0).count(), 1);
    assert_ne!(first, NONE);
}
