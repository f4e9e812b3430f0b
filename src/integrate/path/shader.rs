//! Shaders of materials: those that a front end gave, and those made from glTF's likeness.

use crate::scene::likeness::closure_of;
use crate::scene::shader::Closure;
use crate::scene::{Principled, Shader};
use std::sync::Arc;

/// The shader of a material.
pub fn shader_of(p: &Principled) -> Arc<Shader> {
    p.shader.clone().unwrap_or_else(|| {
        let surface = Some(Closure::Principled(Box::new(closure_of(p))));
        Arc::new(Shader { surface, transparent_shadow: true, ..Shader::default() })
    })
}
