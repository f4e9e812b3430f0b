//! Materials: a shader for the path integrator, and its likeness for the others.

use super::super::super::ImportError;
use super::super::material::Cover;
use super::closure::MAX_CLOSURES;
use super::input::{Inputs, common_uv_set};
use super::likeness::likeness;
use super::record::Record;
use super::{Extension, NAME, part};
use crate::diag::Sink;
use crate::scene::shader::EmissionSampling;
use crate::scene::{Interior, Shader, Texture};
use std::sync::Arc;

/// Puts shaders into the covers of materials that have a record of the extension.
pub(in super::super) fn shaders(e: &mut Extension, covers: &mut [Cover], sink: &mut Sink) -> Result<(), ImportError> {
    let doc = e.doc;
    for (ix, material) in doc.root.materials.iter().enumerate() {
        let Some(value) = part(material.extensions.as_ref().map(|e| &e.others)) else { continue };
        let r = Record::new(doc, value, format!("materials[{ix}].extensions.{NAME}"))?;
        let (shader, uv_set) = shader(e, &r, material.name.as_deref().unwrap_or_default(), sink)?;
        let mut p = likeness(&shader);
        let interior = (p.transmission > 0.0).then(|| Arc::new(Interior { ior: f64::from(p.ior), ..Interior::default() }));
        p.shader = Some(Arc::new(shader));
        covers[ix] = Cover { texture: Arc::new(Texture::Principled(Box::new(p))), interior, uv_set, all_uvs: true };
    }
    Ok(())
}

/// The shader, and the set of coordinates that stands first.
fn shader<'a>(e: &mut Extension<'a>, r: &Record<'a>, name: &str, sink: &mut Sink) -> Result<(Shader, u32), ImportError> {
    let nodes = r.records("nodes")?;
    let first_uv = common_uv_set(&nodes)?;
    let surface = r.index("surface", nodes.len(), "shader node")?;
    let volume = r.index("volume", nodes.len(), "shader node")?;
    let sampling = [
        ("auto", EmissionSampling::Auto),
        ("none", EmissionSampling::None),
        ("front", EmissionSampling::Front),
        ("back", EmissionSampling::Back),
        ("frontBack", EmissionSampling::FrontBack),
    ];
    let mut out = Shader {
        emission_sampling: r.choice("emissionSampling", EmissionSampling::Auto, &sampling)?,
        material_id: r.count_or("passIndex", 0)?,
        name: name.to_owned(),
        transparent_shadow: r.flag("transparentShadow", true)?,
        ..Shader::default()
    };
    for key in ["homogeneousVolume", "volumeStepRate", "displacement"] {
        r.get(key);
    }
    let mut inputs = Inputs { nodes, extension: e, sink, owner: format!("Material '{name}'"), first_uv };
    let mut budget = MAX_CLOSURES;
    if let Some(ix) = surface {
        out.surface = Some(inputs.closure(ix, &mut budget)?);
    } else if volume.is_none() {
        out.surface = Some(super::closure::black());
    }
    if let Some(ix) = volume {
        out.volume = inputs.volume(ix, &mut budget)?;
    }
    r.finish()?;
    Ok((out, first_uv))
}
