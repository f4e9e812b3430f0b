//! A device that goes away while it renders: an error that says so, and what was rendered stays in the film.

use crate::found;
use rayloom::backend::gpu::{GpuBackend, GpuOptions};
use rayloom::backend::{Backend, BackendError, Progress};
use rayloom::compile::{CompileOptions, compile_scene};
use rayloom::film::Film;
use rayloom::integrate::RenderSettings;
use rayloom::math::{DVec3, Vec3};
use rayloom::scene::{Light, Object, Scene, Shape};
use std::sync::atomic::AtomicBool;

/// Takes the device away as soon as some pixels are done.
struct Destroyer<'b>(&'b GpuBackend);

impl Progress for Destroyer<'_> {
    fn pixels(&self, done: u64, total: u64) {
        if done > 0 && done < total {
            self.0.destroy_device();
        }
    }
}

#[test]
fn a_lost_device_is_an_error_and_keeps_what_was_rendered() {
    let Some(gpu) = found(GpuBackend::new(&GpuOptions { accept_software: true, ..GpuOptions::default() })) else { return };
    let mut scene = Scene { objects: vec![Object::new(Shape::Sphere { center: DVec3::Z * 3.0, radius: 1.0 })], ..Scene::default() };
    scene.lights.push(Light::point(DVec3::new(3.0, 4.0, -3.0), Vec3::ONE));
    let compiled = compile_scene(&scene, &CompileOptions::default()).expect("compiles");
    // More pixels than are traced at once.
    let settings = RenderSettings { antialias: None, ..RenderSettings::plain(1024, 1024) };
    let mut film = Film::new(1024, 1024);
    let error = gpu.render(&compiled, &settings, &mut film, &Destroyer(&gpu), &AtomicBool::new(false)).expect_err("the device is gone");
    assert!(matches!(&error, BackendError::DeviceLost(_)), "{error}");
    let n_done = film.samples.iter().filter(|n| **n > 0).count();
    assert!(n_done > 0 && n_done < film.samples.len(), "{n_done} pixels are done");
}
