//! Cases 12, 23 and 24: whole pictures, rendered by both integrators.

use super::figures::{CPU, Report, scene};
use crate::backend::cpu::CpuBackend;
use crate::backend::{Backend, BackendError};
use crate::compare::{CompareOptions, Flip, Picture, compare};
use crate::compile::CompiledScene;
use crate::film::Film;
use crate::integrate::{IntegratorKind, RenderSettings};
use std::sync::atomic::AtomicBool;

const SIZE: (u32, u32) = (96, 72);

fn render(on: &dyn Backend, scene: &CompiledScene, integrator: IntegratorKind, samples: u32) -> Result<Picture, BackendError> {
    let mut film = Film::new(SIZE.0, SIZE.1);
    let settings =
        RenderSettings { samples: 0..samples, integrator, threads: rayon::current_num_threads(), ..RenderSettings::plain(SIZE.0, SIZE.1) };
    on.render(scene, &settings, &mut film, &(), &AtomicBool::new(false))?;
    Ok(Picture { width: SIZE.0, height: SIZE.1, pixels: film.pixels, has_alpha: false, linear: true, depth: "32-bit float".into() })
}

/// The CPU with both integrators, and each GPU with POV-Ray's.
fn for_each_machine(report: &mut Report, mut measure: impl FnMut(&mut Report, &str, String, &dyn Backend, IntegratorKind)) {
    let cpu = CpuBackend::new(rayon::current_num_threads());
    for (name, integrator) in [("classic", IntegratorKind::Classic), ("path", IntegratorKind::Path)] {
        measure(report, name, CPU.into(), &cpu, integrator);
    }
    #[cfg(feature = "gpu")]
    for gpu in std::mem::take(&mut report.gpus) {
        let name = gpu.name();
        let backend = crate::backend::gpu::GpuBackend::on(gpu);
        measure(report, "classic", name, &backend, IntegratorKind::Classic);
        report.gpus.push(backend.into_device());
    }
}

fn still_life(at: [f64; 3], extra: &str) -> String {
    let [x, y, z] = at;
    format!(
        "#version 3.7; global_settings {{ assumed_gamma 1 }} #declare P = <{x},{y},{z}>;
         camera {{ location P+<0,2,-5> look_at P+<0,0.6,0> }} light_source {{ P+<4,6,-3>, 1 }} background {{ rgb 0.3 }}
         plane {{ y, {y} pigment {{ rgb 0.6 }} }} sphere {{ P+<-1,0.7,0>, 0.7 pigment {{ rgb <0.8,0.3,0.2> }} }}
         box {{ P+<0.2,0,-0.4>, P+<1,0.9,0.5> pigment {{ rgb <0.2,0.5,0.8> }} finish {{ reflection 0.2 }} }}
         cylinder {{ P+<0,0,1.2>, P+<0,1.6,1.2>, 0.4 pigment {{ rgb 0.7 }} }}
         torus {{ 0.4, 0.1 pigment {{ rgb <0.9,0.8,0.2> }} translate P+<1.7,0.1,-0.6> }} {extra}"
    )
}

pub(super) fn far_away(report: &mut Report) {
    let (here, there) = (scene(&still_life([0.0; 3], "")), scene(&still_life([1e6, 1e6, -1e6], "")));
    for_each_machine(report, |report, name, machine, on, integrator| {
        let flip = render(on, &here, integrator, 4).and_then(|a| {
            let b = render(on, &there, integrator, 4)?;
            let options = CompareOptions { flip: Flip::Ldr, ..CompareOptions::default() };
            Ok(compare(a, b, &options).and_then(|m| m.flip).map_or(f64::NAN, |f| f.1))
        });
        let n = u64::from(SIZE.0 * SIZE.1);
        report.add(machine, format!("mean FLIP between the scene at 0 and at (1e6, 1e6, -1e6), {name}"), flip.unwrap_or(f64::NAN), 0.01, n);
    });
}

pub(super) fn no_numbers(report: &mut Report) {
    let spoilt = [
        ("a colour of 1e38", "sphere { <0,2,2>, 0.4 pigment { rgb 1e38 } finish { emission 1 } }"),
        ("a colour of infinity", "sphere { <0,2,2>, 0.4 pigment { rgb 1e308*1e10 } finish { emission 1 } }"),
        ("a light of infinity", "light_source { <0,5,0>, 1e308*1e10 }"),
        ("a function that is NaN", "sphere { <0,2,2>, 0.4 pigment { function { sqrt(-1-x*x) } } }"),
    ];
    for (what, text) in spoilt {
        let scene = scene(&still_life([0.0; 3], text));
        for_each_machine(report, |report, name, machine, on, integrator| {
            let bad = render(on, &scene, integrator, 4).map(|p| p.pixels.iter().flatten().filter(|v| !v.is_finite()).count());
            let n = u64::from(SIZE.0 * SIZE.1);
            report.add(machine, format!("values that are no numbers, {what}, {name}"), bad.map_or(f64::NAN, |b| b as f64), 0.0, n);
        });
    }
}

pub(super) fn furnace(report: &mut Report) {
    // Two balls that see each other in a white world: whatever the way of the light, 1 comes back.
    let mut scene = scene(
        "#version 3.7; global_settings { assumed_gamma 1 } camera { location -5*z look_at 0 } background { rgb 1 }
         sphere { -1.05*x, 1 pigment { rgb 1 } finish { diffuse 1 } } sphere { 1.05*x, 1 pigment { rgb 1 } finish { diffuse 1 } }",
    );
    let p = &mut scene.settings.path;
    (p.max_bounces, p.diffuse_bounces, p.min_light_bounces) = (64, 64, 64);
    let samples = (report.effort.rays / 200_000).clamp(16, 4096) as u32;
    let cpu = CpuBackend::new(rayon::current_num_threads());
    let mean = render(&cpu, &scene, IntegratorKind::Path, samples).map_or(f64::NAN, |p| {
        let sum: f64 = p.pixels.iter().flat_map(|p| &p[..3]).map(|v| f64::from(*v)).sum();
        sum / (3 * p.pixels.len()) as f64
    });
    report.cpu("difference of the mean from 1", (mean - 1.0).abs(), 1e-4, u64::from(SIZE.0 * SIZE.1 * samples));
}
