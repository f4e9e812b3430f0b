//! Colour maps that POV-Ray gives pigments without one. Source: spec/textures.md, section 1 (measured).

use super::PatternCode;
use crate::math::Rgbft;
use crate::scene::pattern::FractalPattern;

type Rgb3 = [f32; 3];
type Entries = Vec<(f32, Rgbft)>;

const BLACK: Rgb3 = [0.0, 0.0, 0.0];
const WHITE: Rgb3 = [1.0, 1.0, 1.0];
const RED: Rgb3 = [1.0, 0.0, 0.0];
const GREEN: Rgb3 = [0.0, 1.0, 0.0];
const BLUE: Rgb3 = [0.0, 0.0, 1.0];
const YELLOW: Rgb3 = [1.0, 1.0, 0.0];
const CYAN: Rgb3 = [0.0, 1.0, 1.0];
const MAGENTA: Rgb3 = [1.0, 0.0, 1.0];

fn entries(list: &[(f32, Rgb3)]) -> Entries {
    list.iter().map(|(at, [r, g, b])| (*at, Rgbft::rgb(*r, *g, *b))).collect()
}

fn listed(colors: &[Rgb3]) -> Entries {
    colors.iter().enumerate().map(|(k, [r, g, b])| (k as f32, Rgbft::rgb(*r, *g, *b))).collect()
}

/// The entries for a pattern. `spotted` tells it from bozo, which shares its code.
pub(super) fn default_map(code: &PatternCode, spotted: bool, fractals: &[FractalPattern]) -> Entries {
    match *code {
        PatternCode::Noise if !spotted => {
            entries(&[(0.4, WHITE), (0.4, GREEN), (0.6, GREEN), (0.6, BLUE), (0.8, BLUE), (0.8, RED), (1.0, RED)])
        }
        PatternCode::Wood => {
            let (light, dark) = ([0.666, 0.312, 0.2], [0.4, 0.1333, 0.066]);
            entries(&[(0.6, light), (0.6, dark)])
        }
        PatternCode::Fractal(ix) => {
            let f = &fractals[ix as usize];
            if f.magnet == 0 && f.julia.is_none() && f.exponent == 2 {
                entries(&[(0.001, BLACK), (0.001, CYAN), (0.012, YELLOW), (0.015, MAGENTA), (0.1, CYAN)])
            } else {
                entries(&[(0.0, BLACK), (1.0, WHITE)])
            }
        }
        PatternCode::Agate { .. } => entries(&[
            (0.0, WHITE),
            (0.5, [0.95, 0.75, 0.5]),
            (0.5, [0.9, 0.7, 0.5]),
            (0.6, [0.9, 0.7, 0.4]),
            (0.6, [1.0, 0.7, 0.4]),
            (1.0, [0.6, 0.3, 0.0]),
        ]),
        PatternCode::Radial => entries(&[(0.0, CYAN), (0.333, YELLOW), (0.666, MAGENTA), (1.0, CYAN)]),
        PatternCode::Marble => entries(&[(0.0, [0.9, 0.8, 0.8]), (0.9, [0.9, 0.08, 0.08]), (0.9, BLACK)]),
        PatternCode::Brick { .. } => listed(&[[0.5; 3], [0.6, 0.15, 0.15]]),
        PatternCode::Hexagon => listed(&[BLUE, GREEN, RED]),
        PatternCode::Checker | PatternCode::Object(_) => listed(&[BLUE, GREEN]),
        PatternCode::Square => listed(&[RED, GREEN, BLUE, YELLOW]),
        PatternCode::Cubic | PatternCode::Triangular => listed(&[RED, GREEN, BLUE, YELLOW, CYAN, MAGENTA]),
        _ => entries(&[(0.0, BLACK), (1.0, WHITE)]),
    }
}
