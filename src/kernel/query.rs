//! Answers for front ends about objects and functions that are not part of a scene yet: `trace`, `inside`, extents, values.

use super::function::{call_function_all, free_point};
use super::inside::inside_object;
use super::pigment::eval_pigment;
use super::spline::eval_spline;
use super::traverse::{MIN_DEPTH, intersect_object};
use crate::compile::extent::pov_extent;
use crate::compile::{CompiledScene, compile_function, compile_object, compile_pigment};
use crate::math::{Bounds, DVec3, MAX_DISTANCE, Ray, Rgbft};
use crate::scene::spline::SplineKind;
use crate::scene::{Function, Object, Pigment, SceneQuery, Settings, Shape, Spline};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// How many compiled objects are kept.
const KEPT: usize = 256;

/// The kernel as [`SceneQuery`]; keeps what it compiles, so that asking again is cheap.
#[derive(Debug, Default)]
pub struct KernelQuery {
    noise: Mutex<(u8, u32)>,
    objects: Kept<Object, CompiledScene>,
    functions: Kept<Function, (CompiledScene, u32)>,
    pigments: Kept<Pigment, (CompiledScene, u32)>,
}

/// What was compiled of a part; the part's `Arc` keeps its address taken.
type Known<K, C> = (Arc<K>, Option<Arc<C>>);

/// Compiled parts of one kind, by address.
#[derive(Debug)]
struct Kept<K, C>(Mutex<HashMap<usize, Known<K, C>>>);

impl<K, C> Default for Kept<K, C> {
    fn default() -> Self {
        Self(Mutex::new(HashMap::new()))
    }
}

impl<K, C> Kept<K, C> {
    fn clear(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    /// What was compiled of `part`, now or before. What cannot be compiled is said when the scene is; here it is not there.
    fn get(&self, part: &Arc<K>, compile: impl FnOnce() -> Option<Arc<C>>) -> Option<Arc<C>> {
        let address = Arc::as_ptr(part) as usize;
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, c)) = kept.get(&address) {
            return c.clone();
        }
        let c = compile();
        if kept.len() >= KEPT {
            kept.clear();
        }
        kept.insert(address, (part.clone(), c.clone()));
        c
    }
}

impl KernelQuery {
    /// Nothing compiled yet.
    pub fn new() -> Self {
        Self::default()
    }

    fn settings(&self) -> Settings {
        let noise = self.noise.lock().unwrap_or_else(PoisonError::into_inner);
        let mut settings = Settings::default();
        if noise.0 != 0 {
            (settings.noise_generator, settings.number_of_waves) = *noise;
        }
        settings
    }

    fn compiled(&self, object: &Arc<Object>) -> Option<Arc<CompiledScene>> {
        self.objects.get(object, || compile_object(object, &self.settings()).ok().map(Arc::new))
    }
}

impl SceneQuery for KernelQuery {
    fn use_noise(&self, generator: u8, number_of_waves: u32) {
        let mut noise = self.noise.lock().unwrap_or_else(PoisonError::into_inner);
        if *noise != (generator, number_of_waves) {
            *noise = (generator, number_of_waves);
            self.objects.clear();
            self.functions.clear();
            self.pigments.clear();
        }
    }

    fn trace(&self, object: &Arc<Object>, ray: &Ray) -> Option<(DVec3, DVec3)> {
        let g = self.compiled(object)?;
        if !(ray.origin.is_finite() && ray.dir.is_finite()) {
            return None;
        }
        intersect_object(&g, 0, ray, MIN_DEPTH, MAX_DISTANCE).map(|h| (h.point, h.normal))
    }

    fn inside(&self, object: &Arc<Object>, point: DVec3) -> Option<bool> {
        let g = self.compiled(object)?;
        let composite = matches!(object.shape, Shape::Csg { .. } | Shape::Group { .. } | Shape::LightGroup { .. });
        g.geometry.objects.first().filter(|o| o.solid || composite).map(|_| inside_object(&g, 0, point))
    }

    fn extent(&self, object: &Arc<Object>) -> Bounds {
        pov_extent(object)
    }

    fn call(&self, function: &Arc<Function>, args: &[f64]) -> ([f64; 5], usize) {
        let compile = || compile_function(function, &self.settings()).ok().map(Arc::new);
        match self.functions.get(function, compile) {
            Some(f) => call_function_all(&f.0, f.1, args),
            None => ([0.0; 5], 1),
        }
    }

    fn pigment(&self, pigment: &Arc<Pigment>, point: DVec3) -> Rgbft {
        let compile = || compile_pigment(pigment, &self.settings()).ok().map(Arc::new);
        let found = self.pigments.get(pigment, compile).and_then(|p| eval_pigment(&p.0, p.1, &free_point(point)));
        found.unwrap_or(Rgbft::BLACK)
    }

    fn spline(&self, spline: &Spline, t: f64, kind: Option<SplineKind>) -> [f64; 5] {
        eval_spline(spline, t, kind)
    }
}
