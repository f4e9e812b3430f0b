//! OpenEXR: 32-bit floats of linear light, premultiplied, with the samples of each pixel in a channel of their own, so that
//! parts can be merged. The data window is the part that was rendered, the display window the picture.
//! Films with passes become Blender's kind of multilayer file (`exr_layers`).

use super::{Encoding, Film, FilmError, Metadata, exr_layers};
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Compression, FlatSamples, Image, IntegerBounds, Layer, LayerAttributes, Text, Vec2,
    WritableImage, read_first_flat_layer_from_file,
};
use std::path::Path;

/// Name of the channel that counts samples.
const SAMPLES: &str = "samples";
/// Before the names of our attributes, so that none is taken for one of the standard's.
const PREFIX: &str = "rayloom:";
/// By this attribute Blender knows a multilayer file.
const MULTILAYER: (&str, &str) = ("BlenderMultiChannel", "Blender V2.55.1 and newer");
/// Before the names of Cryptomatte's attributes.
const CRYPTOMATTE: &str = "cryptomatte/";

/// A picture read from an EXR file.
#[derive(Clone, Debug)]
pub struct Part {
    /// The whole picture in linear light; pixels outside the data window have no samples.
    pub film: Film,
    /// The file has alpha.
    pub alpha: bool,
    /// What the file says about itself.
    pub metadata: Metadata,
}

/// Columns and rows that were rendered: `[x0, y0, x1, y1]`, ends exclusive; everything when nothing was.
fn window(film: &Film) -> [usize; 4] {
    let (w, h) = (film.width as usize, film.height as usize);
    let rendered = |row: &[u32]| row.iter().any(|n| *n > 0);
    let Some(y0) = film.samples.chunks(w).position(rendered) else { return [0, 0, w, h] };
    let y1 = h - film.samples.chunks(w).rev().position(rendered).unwrap_or(0);
    let column = |x: &usize| (y0..y1).any(|y| film.samples[y * w + x] > 0);
    let (x0, x1) = ((0..w).find(column).unwrap_or(0), (0..w).rev().find(column).map_or(w, |x| x + 1));
    [x0, y0, x1, y1]
}

/// The bytes of an EXR file.
pub(super) fn encode(film: &Film, encoding: &Encoding, metadata: &Metadata) -> Result<Vec<u8>, FilmError> {
    let [x0, y0, x1, y1] = window(film);
    let indices: Vec<usize> = (y0..y1).flat_map(|y| (x0..x1).map(move |x| y * film.width as usize + x)).collect();
    let (noisy, shown) = (film, film.shown());
    let film = &*shown;
    let plane_of =
        |film: &Film, value: &dyn Fn(&[f32; 4]) -> f32| FlatSamples::F32(indices.iter().map(|i| value(&film.pixels[*i])).collect());
    let plane = |value: &dyn Fn(&[f32; 4]) -> f32| plane_of(film, value);
    let is_multilayer = !film.layers.is_empty();
    let named = |c: &str| if is_multilayer { exr_layers::color_channel(c) } else { c.to_owned() };
    let color = |k: usize, c: &str| AnyChannel::new(named(c).as_str(), plane(&|p| encoding.linear(p[k])));
    let mut channels = vec![color(0, "R"), color(1, "G"), color(2, "B")];
    if is_multilayer {
        let counts = FlatSamples::F32(indices.iter().map(|i| film.samples[*i] as f32).collect());
        channels.push(AnyChannel::new(exr_layers::count_channel().as_str(), counts));
        channels.append(&mut exr_layers::encode(film, &indices));
        if noisy.denoised.is_some() {
            for (k, c) in ["R", "G", "B"].into_iter().enumerate() {
                channels.push(AnyChannel::new(exr_layers::noisy_channel(c).as_str(), plane_of(noisy, &|p| encoding.linear(p[k]))));
            }
            let alpha = plane(&|p| if encoding.alpha { (1.0 - p[3]).clamp(0.0, 1.0) } else { 1.0 });
            channels.push(AnyChannel::new(exr_layers::noisy_channel("A").as_str(), alpha));
        }
    } else {
        channels.push(AnyChannel::new(SAMPLES, FlatSamples::U32(indices.iter().map(|i| film.samples[*i]).collect())));
    }
    if encoding.alpha {
        channels.push(AnyChannel::new(named("A").as_str(), plane(&|p| (1.0 - p[3]).clamp(0.0, 1.0))));
    } else if is_multilayer {
        channels.push(AnyChannel::new(named("A").as_str(), plane(&|_| 1.0)));
    }
    let mut layer = Layer::new(
        (x1 - x0, y1 - y0),
        LayerAttributes { layer_position: Vec2(x0 as i32, y0 as i32), ..LayerAttributes::default() },
        exr::image::Encoding { compression: Compression::ZIP16, ..exr::image::Encoding::default() },
        AnyChannels::sort(channels.into()),
    );
    layer.attributes.software_name = Some(text(&metadata.software));
    layer.attributes.other.insert(text(&format!("{PREFIX}scene")), AttributeValue::Text(text(&metadata.scene)));
    if is_multilayer {
        layer.attributes.other.insert(text(MULTILAYER.0), AttributeValue::Text(text(MULTILAYER.1)));
        layer.attributes.other.insert(text(&format!("{PREFIX}alpha")), AttributeValue::Text(text(if encoding.alpha { "1" } else { "0" })));
    }
    for (name, value) in &metadata.attributes {
        layer.attributes.other.insert(text(name), AttributeValue::Text(text(value)));
    }
    for (name, value) in &metadata.entries {
        layer.attributes.other.insert(text(&format!("{PREFIX}{name}")), AttributeValue::Text(text(value)));
    }
    let mut picture = Image::from_layer(layer);
    picture.attributes.display_window = IntegerBounds::from_dimensions((film.width as usize, film.height as usize));
    let mut out = std::io::Cursor::new(Vec::new());
    picture.write().to_buffered(&mut out).map_err(|e| FilmError::Unfit { format: "OpenEXR", reason: e.to_string() })?;
    Ok(out.into_inner())
}

/// Attributes are bytes; what is not Latin-1 becomes `?`.
fn text(s: &str) -> Text {
    Text::new_or_none(s).unwrap_or_else(|| {
        let plain: String = s.chars().map(|c| if u32::from(c) < 256 { c } else { '?' }).collect();
        Text::new_or_panic(plain)
    })
}

/// Reads an EXR file: ours, or any with R, G and B (or Y), whose pixels then count one sample each.
///
/// # Errors
/// Unreadable files, files of more than `max_pixels` (found before any pixel is read), files without colours.
pub fn read_exr(path: &Path, max_pixels: u64) -> Result<Part, FilmError> {
    let foreign = |reason: String| FilmError::Foreign { path: path.to_owned(), reason };
    let file = std::fs::File::open(path).map_err(|e| FilmError::io("read", path, e))?;
    let header = exr::meta::MetaData::read_from_buffered(std::io::BufReader::new(file), false).map_err(|e| foreign(e.to_string()))?;
    let display = header.headers.first().ok_or_else(|| foreign("the file has no picture".into()))?.shared_attributes.display_window;
    let (width, height) = (display.size.0, display.size.1);
    let data: u64 = header.headers.iter().map(|h| h.layer_size.area() as u64).sum();
    if width == 0 || height == 0 {
        return Err(foreign("the picture has no pixels".into()));
    }
    if (width as u64 * height as u64).max(data) > max_pixels {
        return Err(foreign(format!("{width} by {height} pixels are more than the limit of {max_pixels}")));
    }
    let picture = read_first_flat_layer_from_file(path).map_err(|e| foreign(e.to_string()))?;
    let layer = picture.layer_data;
    let channel = |name: &str| layer.channel_data.list.iter().find(|c| c.name.eq_case_insensitive(name)).map(|c| &c.sample_data);
    let is_multilayer = channel(&exr_layers::color_channel("R")).is_some();
    let color = |c: &str| if is_multilayer { channel(&exr_layers::color_channel(c)) } else { channel(c) };
    let grey = channel("Y");
    let (Some(r), Some(g), Some(b)) = (color("R").or(grey), color("G").or(grey), color("B").or(grey)) else {
        return Err(foreign("the file has no channels R, G and B".into()));
    };
    let n = if is_multilayer { channel(&exr_layers::count_channel()) } else { channel(SAMPLES) };
    let mut film = Film::new(width as u32, height as u32);
    let offset = layer.attributes.layer_position - display.position;
    // Where each pixel of the data window lies in the picture, if it does.
    let place = |k: usize| {
        let (px, py) = (offset.0 as i64 + (k % layer.size.0) as i64, offset.1 as i64 + (k / layer.size.0) as i64);
        ((0..width as i64).contains(&px) && (0..height as i64).contains(&py)).then(|| py as usize * width + px as usize)
    };
    let places: Vec<Option<usize>> = (0..layer.size.area()).map(place).collect();
    let attributes = &layer.attributes.other;
    let says_opaque = attributes.iter().any(|(k, v)| k.to_string() == format!("{PREFIX}alpha") && *v == AttributeValue::Text(text("0")));
    let a = color("A").filter(|_| !says_opaque);
    for (from, to) in places.iter().enumerate().filter_map(|(from, to)| Some((from, (*to)?))) {
        let value = |s: &FlatSamples| s.value_by_flat_index(from).to_f32();
        film.pixels[to] = [value(r), value(g), value(b), a.map_or(0.0, |a| 1.0 - value(a))];
        film.samples[to] = n.map_or(1, |n| n.value_by_flat_index(from).to_u32());
    }
    if is_multilayer {
        exr_layers::decode(&mut film, &places, channel);
    }
    let noisy = |c: &str| channel(&exr_layers::noisy_channel(c));
    if let (true, Some(r), Some(g), Some(b)) = (is_multilayer, noisy("R"), noisy("G"), noisy("B")) {
        film.denoised = Some(film.pixels.iter().map(|p| [p[0], p[1], p[2]]).collect());
        for (from, to) in places.iter().enumerate().filter_map(|(from, to)| Some((from, (*to)?))) {
            for (k, plane) in [r, g, b].into_iter().enumerate() {
                film.pixels[to][k] = plane.value_by_flat_index(from).to_f32();
            }
        }
    }
    let mut metadata =
        Metadata { software: layer.attributes.software_name.map_or_else(String::new, |t| t.to_string()), ..Metadata::default() };
    let mut entries: Vec<(String, String)> = layer
        .attributes
        .other
        .iter()
        .filter_map(|(name, value)| match value {
            AttributeValue::Text(t) => Some((name.to_string().strip_prefix(PREFIX)?.to_owned(), t.to_string())),
            _ => None,
        })
        .collect();
    entries.sort();
    if let Some(i) = entries.iter().position(|(name, _)| name == "scene") {
        metadata.scene = entries.remove(i).1;
    }
    entries.retain(|(name, _)| name != "alpha");
    metadata.entries = entries;
    let manifest = |(name, value): (&Text, &AttributeValue)| match value {
        AttributeValue::Text(t) if name.to_string().starts_with(CRYPTOMATTE) => Some((name.to_string(), t.to_string())),
        _ => None,
    };
    metadata.attributes = attributes.iter().filter_map(manifest).collect();
    metadata.attributes.sort();
    Ok(Part { alpha: a.is_some(), film, metadata })
}
