//! The world: what rays see that hit nothing.

use super::super::super::ImportError;
use super::closure::MAX_CLOSURES;
use super::input::Inputs;
use super::record::Record;
use super::{Extension, visibility};
use crate::diag::Sink;
use crate::math::{DMat3, DVec3, Rgbft, Vec3};
use crate::scene::Environment;
use crate::scene::environment::{EnvironmentSource, Sky, SkyModel};
use std::sync::Arc;

/// The environment of the record `world`.
pub(super) fn environment<'a>(e: &mut Extension<'a>, r: &Record<'a>, sink: &mut Sink) -> Result<Environment, ImportError> {
    let mut out = Environment::constant(Vec3::ZERO);
    out.visibility = visibility(r)?;
    out.sampled = r.get("sampling").is_none_or(|v| v.as_str() != Some("none"));
    r.count("maxBounces")?;
    let nodes = r.records("nodes")?;
    let surface = r.index("surface", nodes.len(), "shader node")?;
    let volume = r.index("volume", nodes.len(), "shader node")?;
    let nodes_len = nodes.len();
    let mut inputs = Inputs { nodes, extension: e, sink, owner: "World".into(), first_uv: 0 };
    if let Some(ix) = surface {
        background_node(&mut inputs, ix, &mut out)?;
    }
    if let Some(ix) = r.index("cameraSurface", nodes_len, "shader node")? {
        let mut seen = Environment::constant(Vec3::ZERO);
        background_node(&mut inputs, ix, &mut seen)?;
        out.for_camera = Some(Box::new(seen));
    }
    if let Some(ix) = volume {
        out.volume = inputs.volume(ix, &mut { MAX_CLOSURES })?;
    }
    r.finish()?;
    Ok(out)
}

fn background_node(inputs: &mut Inputs, ix: usize, out: &mut Environment) -> Result<(), ImportError> {
    let kind = inputs.kind(ix)?;
    if !matches!(kind, "background" | "emission") {
        inputs.told(&format!("a surface of '{kind}' is left out: it is black"));
        return Ok(());
    }
    let strength = inputs.scalar(ix, "strength", 1.0)?.as_constant().unwrap_or(1.0);
    let Some(node) = inputs.source(ix, "color")? else {
        let color = inputs.color(ix, "color", Vec3::splat(0.8))?;
        out.strength = color.as_constant().unwrap_or(Vec3::ONE) * strength;
        return Ok(());
    };
    out.strength = Vec3::splat(strength);
    match inputs.kind(node)? {
        "environment" => {
            out.rotation = rotation(inputs, node)?;
            let r = &inputs.nodes[node];
            let linear = r.text("interpolation")? != Some("closest");
            let ball = r.text("projection")? == Some("mirrorBall");
            let image = r.needed("image", r.index("image", inputs.extension.pictures.len(), "picture")?)?;
            match inputs.extension.pictures.linear(image, inputs.sink).map(Arc::new) {
                Some(image) if ball => out.source = EnvironmentSource::MirrorBall { image, linear },
                Some(image) => out.source = EnvironmentSource::Equirect { image, linear },
                // Cycles' colour of pictures that are not there.
                None => out.strength = Vec3::new(strength, 0.0, strength),
            }
        }
        "sky" => {
            out.rotation = rotation(inputs, node)?;
            out.source = EnvironmentSource::Sky(sky(inputs, node)?);
        }
        other => {
            inputs.told(&format!("a background made by '{other}' is left out: it is grey"));
            out.strength *= 0.5;
        }
    }
    Ok(())
}

/// The turn of a node's coordinates, from the world's directions.
fn rotation(inputs: &mut Inputs, node: usize) -> Result<DMat3, ImportError> {
    let Some(c) = inputs.nodes[node].record("coordinates")? else { return Ok(DMat3::IDENTITY) };
    let source = c.text("source")?.unwrap_or("position").to_owned();
    c.count("uvSet")?;
    let affine = c.numbers::<12>("affine")?;
    c.finish()?;
    if !matches!(source.as_str(), "position" | "generated" | "normal" | "object") {
        inputs.told(&format!("a background along '{source}' is laid over directions"));
    }
    let Some(a) = affine else { return Ok(DMat3::IDENTITY) };
    let row = |k: usize| DVec3::new(a[4 * k], a[4 * k + 1], a[4 * k + 2]);
    let m = DMat3::from_cols(row(0), row(1), row(2)).transpose();
    let size = m.determinant().abs().cbrt();
    if size < 1e-9 {
        inputs.told("a background squeezed flat by its mapping is not turned");
        return Ok(DMat3::IDENTITY);
    }
    let turn = m * (1.0 / size);
    let shifted = [a[3], a[7], a[11]].iter().any(|v| v.abs() > 1e-6);
    if shifted || !(turn * turn.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-4) {
        inputs.told("of the background's mapping only the rotation counts");
    }
    // The nearest rotation, by Gram and Schmidt.
    let x = turn.x_axis.normalize();
    let y = (turn.y_axis - x * turn.y_axis.dot(x)).normalize();
    let z = x.cross(y) * turn.determinant().signum();
    Ok(DMat3::from_cols(x, y, z))
}

fn sky(inputs: &mut Inputs, node: usize) -> Result<Sky, ImportError> {
    let r = &inputs.nodes[node];
    let d = Sky::default();
    let model = r.text("model")?.unwrap_or("nishita");
    let sky = Sky {
        model: match model {
            "multipleScattering" => SkyModel::Multiple,
            "singleScattering" => SkyModel::Single,
            _ => SkyModel::Nishita,
        },
        sun_disc: r.flag("sunDisc", d.sun_disc)?,
        sun_size_rad: r.positive_or("sunSize", f64::from(d.sun_size_rad))? as f32,
        sun_intensity: r.positive_or("sunIntensity", f64::from(d.sun_intensity))? as f32,
        sun_elevation_rad: r.number_or("sunElevation", f64::from(d.sun_elevation_rad))? as f32,
        sun_rotation_rad: r.number_or("sunRotation", 0.0)? as f32,
        altitude_m: r.positive_or("altitude", 0.0)? as f32,
        air_density: r.positive_or("airDensity", 1.0)? as f32,
        dust_density: r.positive_or("dustDensity", 1.0)? as f32,
        ozone_density: r.positive_or("ozoneDensity", 1.0)? as f32,
    };
    if matches!(model, "preetham" | "hosekWilkie") {
        // Their sun is a direction, z up.
        let s = r.numbers::<3>("sunDirection")?.unwrap_or([0.0, 0.0, 1.0]);
        let up = DVec3::from_array(s).try_normalize().unwrap_or(DVec3::Z);
        let told = format!("the sky of '{model}' is shown by single scattering");
        let sky = Sky {
            sun_elevation_rad: up.z.clamp(-1.0, 1.0).asin() as f32,
            sun_rotation_rad: up.x.atan2(up.y) as f32,
            sun_disc: false,
            ..sky
        };
        inputs.told(&told);
        return Ok(sky);
    }
    Ok(sky)
}

/// The colour behind everything for the classic integrator: the environment's mean.
pub(super) fn background(environment: Option<&Environment>) -> Rgbft {
    let Some(e) = environment else { return Rgbft { transmit: 1.0, ..Rgbft::BLACK } };
    let mean = match &e.source {
        EnvironmentSource::Constant => Vec3::ONE,
        EnvironmentSource::Equirect { image, .. } | EnvironmentSource::MirrorBall { image, .. } => {
            image.texels.iter().map(|t| t.min(Vec3::splat(10.0))).sum::<Vec3>() / image.texels.len().max(1) as f32
        }
        EnvironmentSource::Sky(_) => Vec3::new(1.0, 1.5, 2.5),
    };
    let c = mean * e.strength;
    Rgbft { transmit: 1.0, ..Rgbft::rgb(c.x, c.y, c.z) }
}
