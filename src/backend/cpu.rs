//! The CPU: blocks of pixels on all cores. The picture does not depend on the number of threads.
//!
//! POV-Ray gives every thread its own random streams, so its noisy pictures change with the number of threads. Here a scene whose
//! picture depends on the order of rays (`ScenePlan::needs_ordered_rays`) has two: that of POV-Ray's one thread, block after block with
//! streams that run on (`RenderSettings::in_order`), and one whose blocks have streams of their own and radiosity's samples of the
//! groups of blocks before, which any number of threads makes alike.

use super::paths::render_paths;
use super::unfinished::{add_samples, clear, unfinished_blocks};
use super::{Backend, BackendError, Progress};
use crate::compile::CompiledScene;
use crate::film::Film;
use crate::integrate::antialias::{Block, Sample, blocks};
use crate::integrate::classic::{PhotonMaps, ScenePlan, Tracer, pretrace_in_order, pretrace_side_by_side};
use crate::integrate::samples::sample_position;
use crate::integrate::{IntegratorKind, RenderSettings};
use rayon::prelude::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Stack of a rendering thread: deep mirrors and nested texture maps recurse. Only touched pages cost memory.
const STACK_BYTES: usize = 256 << 20;

/// The processor that runs the program.
#[derive(Debug)]
pub struct CpuBackend {
    threads: usize,
}

impl CpuBackend {
    /// With at most `threads` threads (at least 1).
    pub fn new(threads: usize) -> Self {
        Self { threads: threads.max(1) }
    }
}

impl Backend for CpuBackend {
    fn name(&self) -> String {
        format!("CPU, {} thread{}", self.threads, if self.threads == 1 { "" } else { "s" })
    }

    fn render(
        &self,
        scene: &CompiledScene,
        settings: &RenderSettings,
        film: &mut Film,
        progress: &dyn Progress,
        cancel: &AtomicBool,
    ) -> Result<(), BackendError> {
        if settings.integrator == IntegratorKind::Path {
            let pool = pool_of(settings.threads.clamp(1, self.threads))?;
            return render_paths(scene, settings, &pool, film, progress, cancel);
        }
        let mut plan = ScenePlan::new(scene, settings.width, settings.height, settings.output_alpha);
        let ordered = settings.in_order && ScenePlan::needs_ordered_rays(scene);
        let threads = if ordered { 1 } else { settings.threads.clamp(1, self.threads) };
        let pool = pool_of(threads)?;
        if ordered {
            // Streams of random numbers cannot be picked up in the middle.
            clear(film, settings.crop);
        }
        if PhotonMaps::are_asked_for(scene, &plan) {
            let told = |done, total| progress.photons(done, total);
            let maps = pool.install(|| PhotonMaps::shoot(scene, &plan, settings.in_order, &told, cancel))?;
            progress.photons_at_rest(&maps.stats);
            plan.photons = Some(Box::new(maps)).filter(|m| !m.is_empty());
        }
        let (all, n_finished) = unfinished_blocks(film, settings);
        let done = AtomicU64::new(n_finished);
        let job = Job { settings, progress, cancel, done, film: Mutex::new(film) };
        let tracer = || Tracer::new(scene, &plan).until(cancel);
        let radiosity = scene.settings.radiosity.as_ref().filter(|_| plan.quality.volumes);
        let longest = settings.width.max(settings.height);
        let go_on = || !cancel.load(Ordering::Relaxed);
        pool.install(|| {
            if ordered {
                let mut main = tracer();
                main.radiosity = radiosity.and_then(|r| pretrace_in_order(r, &all, longest, tracer(), &go_on));
                return all.iter().for_each(|b| job.classic_block(*b, &mut main));
            }
            let gathered = radiosity.map(|r| {
                let whole = blocks(settings.crop, settings.block_size);
                pretrace_side_by_side(r, (&whole, settings.block_size), longest, &tracer, &go_on)
            });
            all.par_iter().with_max_len(1).for_each(|b| job.classic_block(*b, &mut tracer().in_block(*b, 0, gathered.as_ref())));
        });
        Ok(())
    }
}

fn pool_of(threads: usize) -> Result<rayon::ThreadPool, BackendError> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .stack_size(STACK_BYTES)
        .build()
        .map_err(|e| BackendError::Unsupported(format!("threads could not be started: {e}")))
}

struct Job<'j> {
    settings: &'j RenderSettings,
    progress: &'j dyn Progress,
    cancel: &'j AtomicBool,
    done: AtomicU64,
    film: Mutex<&'j mut Film>,
}

impl Job<'_> {
    /// Renders a block, unless cancelled before: `rows(go_on, pixels)` fills it and gives the rows finished.
    fn block(&self, block: Block, n_samples: u32, rows: impl FnOnce(&dyn Fn() -> bool, &mut [Sample]) -> u32) {
        let [x0, y0, x1, y1] = block;
        let go_on = || !self.cancel.load(Ordering::Relaxed);
        if !go_on() {
            return;
        }
        let mut pixels = vec![[0.0f32; 4]; (x1 - x0) as usize * (y1 - y0) as usize];
        let n_rows = rows(&go_on, &mut pixels);
        self.keep(block, n_rows, &pixels, n_samples);
    }

    /// A block of the classic integrator.
    fn classic_block(&self, block: Block, tracer: &mut Tracer) {
        let n = if self.settings.antialias.is_some() { 1 } else { self.settings.samples.len().max(1) };
        self.block(block, n as u32, |go_on, pixels| {
            let rows = match &self.settings.antialias {
                Some(aa) => aa.render_block(block, |x, y| tracer.pixel(x, y), go_on, pixels),
                None if n == 1 => rows_of(block, go_on, pixels, |x, y| tracer.pixel(f64::from(x), f64::from(y))),
                None => rows_of(block, go_on, pixels, |x, y| {
                    mean_of(self.settings, |k| {
                        let (dx, dy) = sample_position(x, y, k, self.settings.seed);
                        tracer.pixel(f64::from(x) + dx, f64::from(y) + dy)
                    })
                }),
            };
            // Rays that a cancel cut short left their mark on the last row, and on the one above (antialiasing looks up).
            if go_on() { rows } else { rows.saturating_sub(2) }
        });
    }

    /// Puts finished rows of a block on the film.
    fn keep(&self, [x0, y0, x1, _]: Block, rows: u32, pixels: &[Sample], n_samples: u32) {
        let w = (x1 - x0) as usize;
        {
            let mut film = self.film.lock().expect("no thread panics while it holds the film");
            for r in 0..rows {
                for x in x0..x1 {
                    let at = film.index(x, y0 + r);
                    add_samples(&mut film, at, pixels[(r as usize) * w + (x - x0) as usize], n_samples);
                }
            }
            self.progress.picture(&film);
        }
        let [cx0, cy0, cx1, cy1] = self.settings.crop.map(u64::from);
        let finished = u64::from(rows) * w as u64;
        let done = self.done.fetch_add(finished, Ordering::Relaxed) + finished;
        self.progress.pixels(done, (cx1 - cx0) * (cy1 - cy0));
    }
}

/// Mean of the asked samples of a pixel.
fn mean_of(settings: &RenderSettings, mut sample: impl FnMut(u32) -> Sample) -> Sample {
    let mut sum = [0.0f64; 4];
    for k in settings.samples.clone() {
        let c = sample(k);
        (0..4).for_each(|k| sum[k] += f64::from(c[k]));
    }
    sum.map(|v| (v / settings.samples.len() as f64) as f32)
}

/// One value a pixel, row by row; gives the rows finished.
fn rows_of([x0, y0, x1, y1]: Block, go_on: &dyn Fn() -> bool, out: &mut [Sample], mut pixel: impl FnMut(u32, u32) -> Sample) -> u32 {
    let mut places = out.iter_mut();
    for y in y0..y1 {
        if !go_on() {
            return y - y0;
        }
        for (x, place) in (x0..x1).zip(&mut places) {
            *place = pixel(x, y);
        }
    }
    y1 - y0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::{CompileOptions, compile_scene};
    use crate::math::{DVec3, Rgbft, Transform, Vec3};
    use crate::savings::Savings;
    use crate::scene::light::AreaLight;
    use crate::scene::shape::Shape;
    use crate::scene::{Light, Object, Scene, Texture};
    use std::sync::Arc;

    fn settings(threads: usize) -> RenderSettings {
        RenderSettings { threads, block_size: 8, ..RenderSettings::plain(40, 36) }
    }

    /// A white plane below a white light at distance 2 above the origin.
    fn lit_plane() -> Scene {
        let mut plane = Object::new(Shape::Plane { normal: DVec3::Y, distance: 0.0 });
        plane.texture = Some(Arc::new(Texture::solid(Rgbft::rgb(1.0, 1.0, 1.0))));
        let mut scene =
            Scene { lights: vec![Light::point(DVec3::new(0.0, 2.0, 0.0), Vec3::ONE)], objects: vec![plane], ..Scene::default() };
        scene.camera.location = DVec3::new(0.0, 5.0, 0.0);
        scene.camera.direction = DVec3::NEG_Y;
        scene.camera.up = DVec3::Z;
        scene
    }

    fn render(scene: &Scene, settings: &RenderSettings) -> Film {
        render_with(scene, settings, &CompileOptions::default())
    }

    fn render_with(scene: &Scene, settings: &RenderSettings, options: &CompileOptions) -> Film {
        let compiled = compile_scene(scene, options).expect("a small scene");
        let mut film = Film::new(settings.width, settings.height);
        CpuBackend::new(settings.threads).render(&compiled, settings, &mut film, &(), &AtomicBool::new(false)).expect("renders");
        film
    }

    #[test]
    fn pictures_without_skips_are_the_same() {
        let mut scene = lit_plane();
        for (x, radius) in [(-1.0, 0.4), (0.3, 0.7), (1.5, 0.2)] {
            let mut ball = Object::new(Shape::Sphere { center: DVec3::new(x, 1.0, 0.2 * x), radius });
            ball.texture = scene.objects[0].texture.clone();
            scene.objects.push(ball);
        }
        scene.lights.push(Light::point(DVec3::new(3.0, 1.0, -2.0), Vec3::new(0.5, 0.2, 0.1)));
        let area = AreaLight {
            axis1: DVec3::X,
            axis2: DVec3::Z,
            n1: 6,
            n2: 7,
            adaptive: 1,
            jitter: true,
            circular: false,
            orient: true,
            area_illumination: false,
        };
        scene.lights.push(Light { area: Some(area), ..Light::point(DVec3::new(-1.0, 3.0, 1.0), Vec3::splat(0.3)) });
        let without = CompileOptions { savings: Savings::without_exact(), ..CompileOptions::default() };
        let (a, b) = (render(&scene, &settings(1)), render_with(&scene, &settings(1), &without));
        assert_eq!(a.pixels, b.pixels);
        assert!(a.pixels.iter().any(|p| *p != a.pixels[0]), "there is something to see");
    }

    #[test]
    fn lambert_plane_has_ambient_and_the_cosine_of_the_light() {
        let film = render(&lit_plane(), &settings(1));
        for (x, y) in [(20u32, 18u32), (3, 30), (39, 0)] {
            let (a, b) = ((f64::from(x) + 0.5) / 40.0 - 0.5, 0.5 - (f64::from(y) + 0.5) / 36.0);
            let (px, pz) = (5.0 * 1.33 * a, 5.0 * b);
            let cos = 2.0 / (px * px + pz * pz + 4.0f64).sqrt();
            let want = 0.1 + 0.6 * cos;
            let got = film.pixels[film.index(x, y)];
            assert!((f64::from(got[0]) - want).abs() < 1e-6, "({x},{y}): {got:?}, not {want}");
        }
    }

    #[test]
    fn shadow_of_a_sphere_leaves_the_ambient_light() {
        let mut scene = lit_plane();
        let mut ball = Object::new(Shape::Sphere { center: DVec3::ZERO, radius: 0.2 });
        ball.transform = Transform::translation(DVec3::new(0.0, 1.0, 0.0));
        ball.flags.no_image = Some(true);
        scene.objects.push(ball);
        let film = render(&scene, &settings(2));
        assert!((film.pixels[film.index(20, 18)][0] - 0.1).abs() < 1e-6, "no_image still casts a shadow");
    }

    #[test]
    fn pictures_do_not_depend_on_threads_or_crops() {
        let one = render(&lit_plane(), &settings(1));
        assert_eq!(one.pixels, render(&lit_plane(), &settings(2)).pixels);
        let cropped = render(&lit_plane(), &RenderSettings { crop: [5, 9, 21, 30], ..settings(2) });
        for y in 0..36 {
            for x in 0..40 {
                let inside = (5..21).contains(&x) && (9..30).contains(&y);
                let at = one.index(x, y);
                assert_eq!(cropped.samples[at], u32::from(inside));
                assert_eq!(cropped.pixels[at], if inside { one.pixels[at] } else { [0.0; 4] });
            }
        }
    }

    #[test]
    fn pictures_with_noise_and_radiosity_do_not_depend_on_threads_either() {
        let mut scene = lit_plane();
        let mut ball = Object::new(Shape::Sphere { center: DVec3::new(0.0, 0.6, 0.0), radius: 0.6 });
        ball.texture = scene.objects[0].texture.clone();
        scene.objects.push(ball);
        let jittered = AreaLight {
            axis1: DVec3::X,
            axis2: DVec3::Z,
            n1: 3,
            n2: 3,
            adaptive: 0,
            jitter: true,
            circular: false,
            orient: false,
            area_illumination: false,
        };
        scene.lights.push(Light { area: Some(jittered), ..Light::point(DVec3::new(-1.0, 3.0, 1.0), Vec3::splat(0.3)) });
        for radiosity in [None, Some(crate::scene::settings::Radiosity { pretrace: (0.2, 0.05), ..Default::default() })] {
            scene.settings.radiosity = radiosity;
            let apart = |threads| render(&scene, &RenderSettings { in_order: false, ..settings(threads) }).pixels;
            let (one, ordered) = (apart(1), render(&scene, &settings(1)).pixels);
            assert_eq!(one, apart(2));
            assert_eq!(one, apart(3));
            assert_ne!(one, ordered, "there is something random to see");
            let mean = |p: &[[f32; 4]]| p.iter().map(|c| f64::from(c[0])).sum::<f64>() / p.len() as f64;
            assert!((mean(&one) / mean(&ordered) - 1.0).abs() < 5e-3, "{} and {}", mean(&one), mean(&ordered));
        }
    }

    #[test]
    fn cancelled_before_the_start_nothing_is_rendered() {
        let compiled = compile_scene(&lit_plane(), &CompileOptions::default()).expect("a small scene");
        let mut film = Film::new(40, 36);
        CpuBackend::new(2).render(&compiled, &settings(2), &mut film, &(), &AtomicBool::new(true)).expect("renders");
        assert!(film.samples.iter().all(|n| *n == 0));
    }

    #[test]
    fn a_time_limit_leaves_a_whole_picture_and_rounds_change_nothing() {
        let scene = lit_plane();
        let path = RenderSettings { integrator: IntegratorKind::Path, samples: 0..1_000_000, ..settings(2) };
        let start = std::time::Instant::now();
        let limited = render(&scene, &RenderSettings { time_limit: Some(std::time::Duration::from_millis(150)), ..path.clone() });
        assert!(start.elapsed().as_secs_f64() < 20.0);
        assert!(limited.samples.iter().all(|n| (1..1_000_000).contains(n)));
        // A limit that is over at once leaves one sample.
        let one = render(&scene, &RenderSettings { time_limit: Some(std::time::Duration::from_nanos(1)), ..path.clone() });
        assert!(one.samples.iter().all(|n| *n == 1), "{:?}", &one.samples[..4]);
        let quiet = crate::integrate::NoiseLimit { threshold: 0.01, min_samples: 0 };
        for noise in [None, Some(quiet)] {
            let plain = RenderSettings { samples: 0..24, noise, ..path.clone() };
            let rounds = render(&scene, &RenderSettings { in_rounds: true, ..plain.clone() });
            let at_once = render(&scene, &plain);
            assert_eq!(rounds.samples, at_once.samples);
            for (a, b) in rounds.pixels.iter().zip(&at_once.pixels) {
                assert!((0..3).all(|c| (a[c] - b[c]).abs() <= 1e-5 * b[c].abs().max(1e-3)), "{a:?}, not {b:?}");
            }
        }
    }
}
