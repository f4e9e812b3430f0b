//! `rayloom info`: the machines here, or what a scene uses and what was left out for it.

use super::console::{print_error, style};
use clap::Args;
use rayloom::bench::skip::why_not;
use rayloom::compile::geometry::PrimKind;
use rayloom::compile::{CompileOptions, CompiledScene, FeatureSet};
use rayloom::diag::{Severity, Sink, SourceMap, render};
use rayloom::integrate::{Antialias, RenderSettings};
use rayloom::job::{JobError, SceneFormat, all_cores, load_scene};
use rayloom::savings::{Pixels, SAVINGS};
use std::path::PathBuf;
use std::process::ExitCode;

/// `rayloom render`'s own.
const ANTIALIAS: Antialias = Antialias { method: 2, threshold: 0.3, depth: 3, jitter: 0.0, gamma: 2.5 };

/// Arguments of `rayloom info`.
#[derive(Debug, Args)]
pub struct InfoArgs {
    /// A scene; without one, the machines are listed
    scene: Option<PathBuf>,
    /// Folder to search for includes, images and fonts; may be given again
    #[arg(short = 'L', long = "library", value_name = "DIR")]
    library: Vec<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Print the scene as it was understood: every name resolved, every default filled in
    #[arg(long, requires = "scene", conflicts_with = "json")]
    dump: bool,
}

/// Runs it.
pub fn run(args: &InfoArgs) -> ExitCode {
    match &args.scene {
        None => machines(args.json),
        Some(_) => match scene(args) {
            Ok(()) => ExitCode::SUCCESS,
            Err(e) => {
                if !matches!(e, JobError::Scene) {
                    print_error(&e.to_string());
                }
                ExitCode::from(e.exit_code())
            }
        },
    }
}

fn machines(json: bool) -> ExitCode {
    let cpu = format!("CPU, {} threads", all_cores());
    let gpus = rayloom::backend::device_names();
    if json {
        println!("{}", serde_json::json!({"version": env!("CARGO_PKG_VERSION"), "cpu": cpu, "gpus": gpus}));
    } else {
        println!("rayloom {}\n  {cpu}", env!("CARGO_PKG_VERSION"));
        gpus.iter().for_each(|g| println!("  {g}"));
        if gpus.is_empty() {
            println!("  no GPU: {}", rayloom::backend::why_no_device());
        }
    }
    ExitCode::SUCCESS
}

fn scene(args: &InfoArgs) -> Result<(), JobError> {
    let path = args.scene.clone().expect("called with a scene");
    let (mut map, mut sink) = (SourceMap::default(), Sink::default());
    let loaded = load_scene(&path, &args.library, &mut map, &mut sink);
    if args.dump {
        for d in sink.drain() {
            eprint!("{}", render(&d, &map, style()));
        }
        let text = rayloom::scene::dump::dump(&loaded?);
        print!("{}", text.ok_or_else(|| JobError::Options("the scene's text would be larger than 256 MiB".into()))?);
        return Ok(());
    }
    let animations = loaded.as_ref().map_or_else(|_| Vec::new(), |s| s.animations.clone());
    let compiled = loaded.and_then(|s| Ok((rayloom::compile::compile_scene(&s, &CompileOptions::default())?, s.unread)));
    for d in sink.drain().iter().filter(|d| !args.json || d.severity == Severity::Error) {
        eprint!("{}", render(d, &map, style()));
    }
    let (c, unread) = compiled?;
    let (used, unused) = features(&c.features);
    let kinds = kinds(&c);
    // As `rayloom render` takes it without options.
    let render = RenderSettings { antialias: Some(ANTIALIAS), ..RenderSettings::plain(800, 600) };
    let savings = SAVINGS.map(|s| (s, why_not(s.saving, &c, &unread, SceneFormat::of(&path), &render)));
    let tree = c.geometry.tree.stats();
    if args.json {
        let animations: Vec<_> =
            animations.iter().map(|a| serde_json::json!({"name": a.name, "seconds": a.seconds, "channels": a.n_channels})).collect();
        let value = serde_json::json!({
            "scene": path, "primitives": kinds.iter().cloned().collect::<std::collections::BTreeMap<_, _>>(), "lights": c.lights.len(),
            "uses": used, "left_out": unused, "patterns": c.features.patterns, "tree": c.geometry.tree.kind().name(), "tree_bytes": tree.n_bytes,
            "animations": animations,
            "savings": savings.iter().map(|(s, why)| serde_json::json!({"name": s.name, "what": s.what, "same_pixels": s.pixels != Pixels::Different, "does_not_apply": why})).collect::<Vec<_>>(),
            "pictures_not_decoded": unread.pictures[0],
        });
        println!("{value:#}");
        return Ok(());
    }
    println!("{}", path.display());
    let list: Vec<String> = kinds.iter().map(|(k, n)| format!("{n} {k}")).collect();
    println!("  primitives: {}", if list.is_empty() { "none".into() } else { list.join(", ") });
    println!("  lights:     {}", c.lights.len());
    println!("  tree:       {} of {} nodes, {} bytes", c.geometry.tree.kind().name(), tree.n_nodes, tree.n_bytes);
    println!("  patterns:   {}", if c.features.patterns.is_empty() { "none".into() } else { c.features.patterns.join(", ") });
    println!("  uses:       {}", used.join(", "));
    println!("  left out:   {}", unused.join(", "));
    for a in &animations {
        println!("  animation:  '{}', {:.3} to {:.3} s, moves {} properties of nodes", a.name, a.seconds[0], a.seconds[1], a.n_channels);
    }
    println!("  savings, each with a switch (--no-skip=NAME) and a measurement (rayloom bench skip):");
    for (s, why) in &savings {
        println!("    {:<10}  {}{}", s.name, s.what, why.as_ref().map_or(String::new(), |why| format!(" (not here: {why})")));
    }
    Ok(())
}

/// Kinds of primitives with their numbers.
fn kinds(c: &CompiledScene) -> Vec<(String, usize)> {
    let mut counts: Vec<(PrimKind, usize)> = Vec::new();
    for p in &c.geometry.prims {
        match counts.iter_mut().find(|(k, _)| *k == p.kind) {
            Some((_, n)) => *n += 1,
            None => counts.push((p.kind, 1)),
        }
    }
    counts.into_iter().map(|(k, n)| (format!("{k:?}"), n)).collect()
}

/// Names of what a scene uses and of what was left out.
fn features(f: &FeatureSet) -> (Vec<&'static str>, Vec<&'static str>) {
    let all = [
        ("clip programs", f.clip_programs),
        ("transparency", f.transparency),
        ("refraction", f.refraction),
        ("reflection", f.reflection),
        ("normals", f.normals),
        ("turbulence", f.turbulence),
        ("images", f.images),
        ("functions", f.functions),
        ("highlights", f.highlights),
        ("irid", f.irid),
        ("crand", f.crand),
        ("area lights", f.area_lights),
        ("media", f.media),
        ("fog", f.fog),
        ("rainbow", f.rainbow),
        ("sky sphere", f.sky),
        ("radiosity", f.radiosity),
        ("photons", f.photons),
        ("subsurface", f.subsurface),
        ("dispersion", f.dispersion),
        ("physically based materials", f.principled),
        ("uv coordinates", f.uv),
    ];
    let (used, unused): (Vec<_>, Vec<_>) = all.into_iter().partition(|(_, on)| *on);
    (used.into_iter().map(|(n, _)| n).collect(), unused.into_iter().map(|(n, _)| n).collect())
}
