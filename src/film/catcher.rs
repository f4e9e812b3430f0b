//! Shadow catchers: what the sums of their pass (`Pass::ShadowCatcher`) make of a film when all samples are there.
//!
//! A pixel's ten values: light among the catchers alone, where the path has met one (3); light of paths that have met none (3), and the
//! share of the film that those leave open (1); what lies behind the catchers (3). Source: the formulas are Cycles', measured.

use super::Film;
use crate::scene::Pass;

/// How catchers are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CatcherView {
    /// The pass is written: the picture is left without the shadows, which the pass holds.
    pub apart: bool,
    /// The film is transparent: shadows are black and half transparent. Else they darken what lies behind.
    pub transparent: bool,
}

/// Quotients of channels; 1 where nothing is to be divided by.
fn divided(a: [f32; 3], b: &[f32]) -> [f32; 3] {
    std::array::from_fn(|k| if b[k] != 0.0 { a[k] / b[k] } else { 1.0 })
}

impl Film {
    /// Shows the catchers, if the film has their sums; the first three values of the pass become what files hold: the factor that light behind them is to be
    /// multiplied with.
    pub fn resolve_catchers(&mut self, view: CatcherView) {
        let Some(layer) = self.layers.iter_mut().find(|l| l.pass == Pass::ShadowCatcher) else { return };
        for ((pixel, values), n) in self.pixels.iter_mut().zip(layer.values.chunks_exact_mut(10)).zip(&self.samples) {
            if *n == 0 {
                continue;
            }
            let [catchers, objects, behind] = [&values[..3], &values[3..6], &values[7..10]];
            // What the catchers have of all the light.
            let caught: [f32; 3] = std::array::from_fn(|k| pixel[k] - objects[k]);
            let ratio = divided(caught, catchers);
            let alpha = 1.0 - pixel[3].clamp(0.0, 1.0);
            let factor = ratio.map(|r| (1.0 - alpha) + alpha * r);
            let mean = |c: [f32; 3]| (c[0] + c[1] + c[2]) / 3.0;
            let own_alpha = (1.0 - values[6]).clamp(0.0, 1.0);
            *pixel = match (view.apart, view.transparent) {
                (true, _) => [objects[0], objects[1], objects[2], 1.0 - own_alpha],
                (false, true) => [objects[0], objects[1], objects[2], (1.0 - own_alpha) * mean(factor)],
                (false, false) => {
                    let shade = mean(ratio).max(0.0);
                    let [r, g, b] = std::array::from_fn(|k| objects[k] + behind[k] * shade);
                    [r, g, b, 0.0]
                }
            };
            values[..3].copy_from_slice(&factor);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::PassSet;

    /// A film of one pixel: all its light, what it leaves open, its ten values.
    fn shown(pixel: [f32; 4], values: [f32; 10], view: CatcherView) -> ([f32; 4], [f32; 3]) {
        let mut film = Film::with_passes(1, 1, PassSet::NONE.with(Pass::ShadowCatcher));
        (film.pixels[0], film.samples[0]) = (pixel, 4);
        film.layers[0].values.copy_from_slice(&values);
        film.resolve_catchers(view);
        (film.pixels[0], std::array::from_fn(|k| film.layers[0].values[k]))
    }

    #[test]
    fn a_half_shaded_catcher_is_half_black_or_darkens_what_lies_behind() {
        // The floor has 0.4 alone, 0.2 under an object; nothing else is in the pixel.
        let values = [0.4, 0.4, 0.4, 0.0, 0.0, 0.0, 1.0, 0.8, 0.6, 0.2];
        let pixel = [0.2, 0.2, 0.2, 0.0];
        let view = |apart, transparent| CatcherView { apart, transparent };
        assert_eq!(shown(pixel, values, view(false, true)), ([0.0, 0.0, 0.0, 0.5], [0.5; 3]));
        assert_eq!(shown(pixel, values, view(false, false)), ([0.4, 0.3, 0.1, 0.0], [0.5; 3]));
        assert_eq!(shown(pixel, values, view(true, true)), ([0.0, 0.0, 0.0, 1.0], [0.5; 3]));
    }

    #[test]
    fn objects_are_as_they_are() {
        let values = [0.0, 0.0, 0.0, 0.3, 0.2, 0.1, 0.0, 0.0, 0.0, 0.0];
        let view = CatcherView { apart: false, transparent: true };
        assert_eq!(shown([0.3, 0.2, 0.1, 0.0], values, view), ([0.3, 0.2, 0.1, 0.0], [1.0; 3]));
    }
}
