//! Answers for front ends about objects and functions that are not part of a scene yet: `trace`, `inside`, extents, values.

use super::inside::inside_object;
use super::traverse::{MIN_DEPTH, intersect_object};
use crate::compile::extent::pov_extent;
use crate::compile::{CompiledScene, compile_object};
use crate::diag::Sink;
use crate::math::{Bounds, DVec3, MAX_DISTANCE, Ray, Rgbft};
use crate::scene::spline::SplineKind;
use crate::scene::{Function, Object, Pigment, SceneQuery, Shape, Spline};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// How many compiled objects are kept.
const KEPT: usize = 256;

/// The kernel as [`SceneQuery`]; keeps what it compiles, so that asking again is cheap.
#[derive(Debug, Default)]
pub struct KernelQuery {
    /// By address; the `Arc` keeps the address taken.
    objects: Mutex<HashMap<*const Object, (Arc<Object>, Option<Arc<CompiledScene>>)>>,
}

impl KernelQuery {
    /// Nothing compiled yet.
    pub fn new() -> Self {
        Self::default()
    }

    fn compiled(&self, object: &Arc<Object>) -> Option<Arc<CompiledScene>> {
        let mut kept = self.objects.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, g)) = kept.get(&Arc::as_ptr(object)) {
            return g.clone();
        }
        // What cannot be compiled is said when the scene is; here it is not there.
        let g = compile_object(object, &mut Sink::default()).ok().map(Arc::new);
        if kept.len() >= KEPT {
            kept.clear();
        }
        kept.insert(Arc::as_ptr(object), (object.clone(), g.clone()));
        g
    }
}

impl SceneQuery for KernelQuery {
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

    fn call(&self, _function: &Arc<Function>, _args: &[f64]) -> ([f64; 5], usize) {
        ([0.0; 5], 1)
    }

    fn pigment(&self, _pigment: &Arc<Pigment>, _point: DVec3) -> Rgbft {
        Rgbft::BLACK
    }

    fn spline(&self, _spline: &Spline, _t: f64, _kind: Option<SplineKind>) -> [f64; 5] {
        [0.0; 5]
    }
}
