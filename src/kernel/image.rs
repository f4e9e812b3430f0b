//! Pictures as pigments, patterns, bumps and indices. Source: spec/textures.md, section 7 (measured with a 5 x 4 picture).

use super::warp::{torus_coordinates, turns};
use crate::math::color::grey;
use crate::math::{DVec3, EPSILON, Rgbft, Vec3};
use crate::scene::ImageMap;
use crate::scene::image::{Interpolation, MapType, Pixels};
use std::f64::consts::PI;

/// Colour of a picture at a point; `None` outside one that is shown once.
pub fn image_color(map: &ImageMap, p: DVec3) -> Option<Rgbft> {
    let at = position(map, p)?;
    Some(color_at(map, at))
}

/// Colour at (u, v) of a picture as a planar map, wrapping.
pub fn image_color_uv(map: &ImageMap, u: f64, v: f64) -> Rgbft {
    image_color(map, DVec3::new(u, v, 0.0)).unwrap_or(Rgbft::CLEAR)
}

/// Whether `use_alpha` reads transparency: of palettes too that have none, which are 0 everywhere (measured); of other pictures without it, red.
pub fn gives_alpha(map: &ImageMap) -> bool {
    map.image.has_alpha || matches!(map.image.pixels, Pixels::Indexed { .. })
}

/// Value of `image_pattern`, 0..1; 0 outside a picture that is shown once.
pub fn image_pattern_value(map: &ImageMap, p: DVec3) -> f64 {
    let Some(at) = position(map, p) else { return 0.0 };
    let c = color_at(map, at);
    let v = match map.use_alpha {
        false => grey(c.rgb),
        true if gives_alpha(map) => c.transmit,
        true => c.rgb.x,
    };
    f64::from(v).clamp(0.0, 1.0)
}

/// Palette index, or red as 0..=255, at a point; `None` outside a picture that is shown once.
pub fn image_index(map: &ImageMap, p: DVec3) -> Option<usize> {
    let at = position(map, p)?;
    let v = match &map.image.pixels {
        Pixels::Indexed { indices, .. } => sample(map, at, |k| [f32::from(indices[k]), 0.0, 0.0, 0.0, 0.0])[0],
        _ => color_at(map, at).rgb.x * 255.0,
    };
    Some(v.max(0.0) as usize)
}

/// Normal bent by the heights of a picture around a point. The frame depends on the world's y.
pub fn bump_normal(map: &ImageMap, amount: f64, n: DVec3, p: DVec3) -> DVec3 {
    let Some((c, r)) = position(map, p) else { return n };
    let (w, h) = wrapped_size(map);
    let height = |dc: f64, dr: f64| {
        let wrap = |v: f64, size: f64| {
            if v < 0.0 {
                v + size
            } else if v >= size {
                v - size
            } else {
                v
            }
        };
        let at = (wrap(c + dc, w), wrap(r + dr, h));
        let v = match &map.image.pixels {
            // An index stays whole, interpolated or not (measured).
            Pixels::Indexed { indices, .. } if map.use_index => sample(map, at, |k| [f32::from(indices[k]), 0.0, 0.0, 0.0, 0.0])[0].trunc(),
            _ => grey(color_at(map, at).rgb),
        };
        amount * f64::from(v)
    };
    let (h1, h2, h3) = (height(0.0, 0.0), height(-1.0, 1.0), height(1.0, 1.0));
    let (p1, p2, p3) = (DVec3::new(0.0, h1, 0.0), DVec3::new(-1.0, h2, 1.0), DVec3::new(1.0, h3, 1.0));
    let bump = (p2 - p1).cross(p3 - p1).normalize_or_zero();
    let bump = if bump.y < 0.0 { -bump } else { bump };
    let mut y = n;
    let mut x = n.cross(DVec3::Y);
    if x.length_squared() < EPSILON {
        (x, y) = (DVec3::X, DVec3::Y.copysign(n) * DVec3::Y);
    }
    let x = x.normalize();
    let z = x.cross(y).normalize();
    bump.x * x + bump.y * y - bump.z * z
}

fn wrapped_size(map: &ImageMap) -> (f64, f64) {
    (f64::from(map.image.width), f64::from(map.image.height))
}

/// The place in pixels (column to the right, row downwards) that a point falls on.
fn position(map: &ImageMap, p: DVec3) -> Option<(f64, f64)> {
    let (w, h) = wrapped_size(map);
    let (vw, vh) = (w * map.repeat.0, h * map.repeat.1);
    let out = |v: f64| !(0.0..=1.0).contains(&v);
    let (mut u, mut v) = match map.map_type {
        MapType::Planar => {
            if map.once && (out(p.x) || out(p.y)) {
                return None;
            }
            ((p.x * vw) % vw, (p.y * vh) % vh)
        }
        MapType::Spherical => {
            let len = p.length();
            if len == 0.0 {
                return None;
            }
            let theta = turns(p.x, p.z, (p.x * p.x + p.z * p.z).sqrt());
            (theta * vw, (0.5 + (p.y / len).clamp(-1.0, 1.0).asin() / PI) * vh)
        }
        MapType::Cylindrical => {
            if map.once && out(p.y) {
                return None;
            }
            let r = (p.x * p.x + p.z * p.z).sqrt();
            if r == 0.0 {
                return None;
            }
            (turns(p.x, p.z, r) * vw, (p.y * vh) % vh)
        }
        MapType::Torus => {
            let (theta, phi, _) = torus_coordinates(p, 1.0);
            (theta * vw, phi * vh)
        }
    };
    u += EPSILON - map.offset.0 * w;
    v += EPSILON - map.offset.1 * h;
    if map.once && !((0.0..vw).contains(&u) && (0.0..vh).contains(&v)) {
        return None;
    }
    let wrap = |a: f64, n: f64| {
        let r = a % n;
        if r < 0.0 { r + n } else { r }
    };
    Some((wrap(u, w), wrap(-v, h)))
}

fn color_at(map: &ImageMap, at: (f64, f64)) -> Rgbft {
    match &map.image.pixels {
        Pixels::Indexed { indices, palette } => {
            let of = |k: usize| palette.get(usize::from(indices[k])).copied().unwrap_or(Rgbft::BLACK).to_array();
            Rgbft::from_array(sample(map, at, of))
        }
        Pixels::Gray16(values) => {
            let v = sample(map, at, |k| [f32::from(values[k]) / 65535.0, 0.0, 0.0, 0.0, 0.0])[0];
            Rgbft { rgb: Vec3::splat(v), filter: map.filter_all, transmit: map.transmit_all }
        }
        Pixels::Color(values) => {
            let mut c = if map.premultiplied && map.image.has_alpha && map.interpolation != Interpolation::None {
                let c = sample(map, at, |k| {
                    let c = values[k];
                    let alpha = 1.0 - c.transmit;
                    let rgb = c.rgb * alpha;
                    [rgb.x, rgb.y, rgb.z, c.filter, c.transmit]
                });
                let c = Rgbft::from_array(c);
                let alpha = 1.0 - c.transmit;
                Rgbft { rgb: if alpha > 0.0 { c.rgb / alpha } else { c.rgb }, ..c }
            } else {
                Rgbft::from_array(sample(map, at, |k| values[k].to_array()))
            };
            c.filter += map.filter_all;
            c.transmit += map.transmit_all;
            c
        }
    }
}

/// Mixes pixels around a place; `of` gives the channels of a pixel by its number.
fn sample(map: &ImageMap, (column, row): (f64, f64), of: impl Fn(usize) -> [f32; 5]) -> [f32; 5] {
    let (w, h) = (i64::from(map.image.width), i64::from(map.image.height));
    let fit = |i: i64, n: i64| if map.once { i.clamp(0, n - 1) } else { i.rem_euclid(n) };
    let pixel = |i: i64, j: i64| of((fit(j, h) * w + fit(i, w)) as usize);
    if map.interpolation == Interpolation::None {
        return pixel((column as i64).min(w - 1), (row as i64).min(h - 1));
    }
    let (x, y) = (column + 0.5, row + 0.5);
    let (i, j) = (x as i64, y as i64);
    let (p, q) = ((x - i as f64) as f32, (y - j as f64) as f32);
    let mix = |weights: [f32; 4]| {
        let four = [pixel(i, j), pixel(i - 1, j), pixel(i, j - 1), pixel(i - 1, j - 1)];
        std::array::from_fn(|c| (0..4).map(|k| weights[k] * four[k][c]).sum())
    };
    match map.interpolation {
        Interpolation::None | Interpolation::Bilinear => mix([p * q, (1.0 - p) * q, p * (1.0 - q), (1.0 - p) * (1.0 - q)]),
        Interpolation::NormalizedDistance => {
            let (a, b) = (1.0 - p, 1.0 - q);
            let near = [a * a + b * b, p * p + b * b, a * a + q * q, p * p + q * q];
            if let Some(k) = near.iter().position(|d| *d == 0.0) {
                return mix(std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 }));
            }
            let w = near.map(|d| 1.0 / d);
            let sum: f32 = w.iter().sum();
            mix(w.map(|v| v / sum))
        }
        Interpolation::Bicubic => {
            let weights = |t: f32| {
                let s = 1.0 - t;
                [-t * s * s / 2.0, s * (s * (3.0 * t + 1.0) + 1.0) / 2.0, t * (t * (3.0 * s + 1.0) + 1.0) / 2.0, -s * t * t / 2.0]
            };
            let (wx, wy) = (weights(p), weights(q));
            let mut sum = [0.0f32; 5];
            for (dj, b) in wy.iter().enumerate() {
                for (di, a) in wx.iter().enumerate() {
                    let c = pixel(i - 2 + di as i64, j - 2 + dj as i64);
                    sum = std::array::from_fn(|k| sum[k] + a * b * c[k]);
                }
            }
            sum
        }
    }
}
