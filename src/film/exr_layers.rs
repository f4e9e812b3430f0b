//! Passes in OpenEXR files, under the names that Blender gives them: `ViewLayer.Combined.R`, `ViewLayer.DiffDir.G`,
//! `ViewLayer.CryptoObject00.r`. Blender and Nuke read such files as they are.
//!
//! Light of surfaces is held divided by its colour, as Cycles does; names and layout were measured on a file of Blender 4.5.15.

use super::{Film, Layer};
use crate::scene::Pass;
use crate::scene::pass::{CRYPTO_RANKS, Join};
use exr::prelude::{AnyChannel, FlatSamples};

/// Name of the one view layer.
pub const VIEW_LAYER: &str = "ViewLayer";

/// Names of a pass's channels with the place of each in a pixel's values.
fn channels(pass: Pass) -> Vec<(String, usize)> {
    let name = pass.layer();
    if pass.join() == Join::Crypto {
        return (0..2 * CRYPTO_RANKS).map(|k| (format!("{VIEW_LAYER}.{name}{:02}.{}", k / 4, ["r", "g", "b", "a"][k % 4]), k)).collect();
    }
    pass.channels().chars().take(pass.width()).enumerate().map(|(k, c)| (format!("{VIEW_LAYER}.{name}.{c}"), k)).collect()
}

/// Name of a channel of the colours, "R" to "A".
pub(super) fn color_channel(c: &str) -> String {
    format!("{VIEW_LAYER}.Combined.{c}")
}

/// The same of the colours before denoising, where there are both.
pub(super) fn noisy_channel(c: &str) -> String {
    format!("{VIEW_LAYER}.Noisy Image.{c}")
}

/// Name of the channel that counts samples.
pub(super) fn count_channel() -> String {
    format!("{VIEW_LAYER}.{}.X", Pass::SampleCount.layer())
}

/// The passes of the pixels `indices` as channels.
pub(super) fn encode(film: &Film, indices: &[usize]) -> Vec<AnyChannel<FlatSamples>> {
    let mut out = Vec::new();
    for layer in &film.layers {
        let divisor = layer.pass.divisor().and_then(|d| film.layer(d));
        let w = layer.pass.width();
        for (name, k) in channels(layer.pass) {
            let value = |i: &usize| {
                let v = layer.values[i * w + k];
                if layer.pass == Pass::Vector {
                    // Of what moves alone.
                    let met = layer.values[i * w + 4];
                    return if met > 0.0 { v / met } else { 0.0 };
                }
                match divisor.map(|d| d.values[i * w + k]) {
                    None => v,
                    Some(color) if color > 0.0 => v / color,
                    Some(_) => 0.0,
                }
            };
            out.push(AnyChannel::new(name.as_str(), FlatSamples::F32(indices.iter().map(value).collect())));
        }
    }
    out
}

/// Makes the film's layers from a file's channels; `places` are the film's pixels that the samples go to, one after the other.
pub(super) fn decode<'c>(film: &mut Film, places: &[Option<usize>], channel: impl Fn(&str) -> Option<&'c FlatSamples>) {
    let n_pixels = film.pixels.len();
    // What a file has of shadow catchers is no sum that could be added to.
    for pass in Pass::all().filter(|p| p.width() > 0 && *p != Pass::ShadowCatcher) {
        let planes: Option<Vec<_>> = channels(pass).iter().map(|(name, k)| Some((channel(name)?, *k))).collect();
        let Some(planes) = planes else { continue };
        let w = pass.width();
        let mut values = vec![0.0; n_pixels * w];
        if pass == Pass::Vector {
            values.iter_mut().skip(4).step_by(w).for_each(|v| *v = 1.0);
        }
        for (samples, k) in planes {
            for (from, to) in places.iter().enumerate() {
                if let Some(to) = to {
                    values[to * w + k] = samples.value_by_flat_index(from).to_f32();
                }
            }
        }
        film.layers.push(Layer { pass, values });
    }
    // Light as radiance again.
    for k in 0..film.layers.len() {
        let Some(d) = film.layers[k].pass.divisor() else { continue };
        let Some(color) = film.layer(d).map(|d| d.values.clone()) else { continue };
        film.layers[k].values.iter_mut().zip(color).for_each(|(v, c)| *v *= c);
    }
}
