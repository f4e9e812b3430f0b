//! Mandelbrot, Julia and magnet sets in the x, y plane. Source: spec/textures.md, section 2 (measured).

use crate::math::DVec3;
use crate::scene::pattern::FractalPattern;

/// A complex number.
#[derive(Clone, Copy)]
struct C(f64, f64);

impl C {
    fn add(self, o: C) -> C {
        C(self.0 + o.0, self.1 + o.1)
    }
    fn mul(self, o: C) -> C {
        C(self.0 * o.0 - self.1 * o.1, self.0 * o.1 + self.1 * o.0)
    }
    fn scale(self, k: f64) -> C {
        C(self.0 * k, self.1 * k)
    }
    fn plus(self, k: f64) -> C {
        C(self.0 + k, self.1)
    }
    fn square(self) -> C {
        C(self.0 * self.0 - self.1 * self.1, 2.0 * self.0 * self.1)
    }
    fn div(self, o: C) -> C {
        let n = o.norm();
        C((self.0 * o.0 + self.1 * o.1) / n, (self.1 * o.0 - self.0 * o.1) / n)
    }
    fn norm(self) -> f64 {
        self.0 * self.0 + self.1 * self.1
    }
    fn pow(self, e: u32) -> C {
        match e {
            2 => self.square(),
            _ => (1..e).fold(self, |z, _| z.mul(self)),
        }
    }
}

/// Whether the orbit of 0 under z² + c is known to stay bounded: `c` is in the main cardioid or the disc of period 2, and not at the rim,
/// where roundings could carry the orbit out.
fn is_in_large_bulbs(c: C) -> bool {
    const INNER: f64 = 1.0 - 1e-9;
    let y_sq = c.1 * c.1;
    let x = c.0 - 0.25;
    let q = x * x + y_sq;
    q * (q + x) < INNER * 0.25 * y_sq || (c.0 + 1.0) * (c.0 + 1.0) + y_sq < INNER * 0.0625
}

/// The value of a fractal pattern.
pub fn fractal(f: &FractalPattern, p: DVec3) -> f64 {
    let at = C(p.x, p.y);
    // A colour that is the same all over the inside needs no orbit.
    let is_plain = f.magnet == 0 && f.exponent == 2 && f.julia.is_none();
    if is_plain && f.interior.0 == 0 && is_in_large_bulbs(at) {
        return f.interior.1;
    }
    let (mut z, c, mut least) = match (f.magnet, f.julia) {
        (0, None) => (at, at, at.norm()),
        (0, Some((a, b))) => (at, C(a, b), at.norm()),
        (_, None) => (C(0.0, 0.0), at, 10_000.0),
        (_, Some((a, b))) => (at, C(a, b), at.norm()),
    };
    // What does not change from step to step.
    let (c1, c2) = (c.plus(-1.0), c.plus(-2.0));
    let c12 = c1.mul(c2);
    let mut cycle = Cycle { saved: z, age: 0, limit: 8, found: false };
    let (mut i, mut end) = (0, f.iterations);
    while i < end {
        z = match f.magnet {
            0 => z.pow(f.exponent).add(c),
            1 => z.square().add(c1).div(z.scale(2.0).add(c2)).square(),
            _ => {
                let z2 = z.square();
                let above = z2.mul(z).add(c1.mul(z).scale(3.0)).add(c12);
                let below = z2.scale(3.0).add(c2.mul(z).scale(3.0)).add(c12).plus(1.0);
                above.div(below).square()
            }
        };
        let n = z.norm();
        if n < least {
            least = n;
        }
        let escaped = if f.magnet == 0 { n > 4.0 } else { n > 10_000.0 || z.plus(-1.0).norm() < 1e-4 };
        if escaped {
            return exterior(f, z, i);
        }
        i += 1;
        if let Some(period) = cycle.look(z) {
            // All that is to come was there before: only the place in the cycle at the end matters.
            end = i + (end - i) % period;
        }
    }
    interior(f, z, least)
}

/// Finds the first exact repetition of an orbit, after Brent 1980: orbits that do not escape mostly end in a cycle of their roundings.
struct Cycle {
    saved: C,
    age: u32,
    limit: u32,
    found: bool,
}

impl Cycle {
    /// Takes the next point; the period when it is the saved one again, once.
    #[inline(always)]
    fn look(&mut self, z: C) -> Option<u32> {
        if self.found {
            return None;
        }
        self.age += 1;
        if z.0 == self.saved.0 && z.1 == self.saved.1 {
            self.found = true;
            return Some(self.age);
        }
        if self.age == self.limit {
            (self.saved, self.age, self.limit) = (z, 0, self.limit.saturating_mul(2));
        }
        None
    }
}

fn exterior(f: &FractalPattern, z: C, i: u32) -> f64 {
    let (kind, factor) = f.exterior;
    let modulo = |m: f64| if m as i64 == 0 { 0.0 } else { (i64::from(i) % (m as i64)) as f64 / factor };
    match kind {
        0 => factor,
        1 => f64::from(i) / f64::from(f.iterations),
        2 => z.0 * factor,
        3 => z.1 * factor,
        4 => z.0 * z.0 * factor,
        5 => z.1 * z.1 * factor,
        6 => z.norm().sqrt() * factor,
        7 => modulo(factor),
        _ => modulo(1.0 + factor),
    }
}

fn interior(f: &FractalPattern, z: C, least: f64) -> f64 {
    let (kind, factor) = f.interior;
    match kind {
        0 => factor,
        1 => least.sqrt() * factor,
        2 => z.0 * factor,
        3 => z.1 * factor,
        4 => z.0 * z.0 * factor,
        5 => z.1 * z.1 * factor,
        // Only the imaginary part is multiplied (measured).
        _ => z.0 * z.0 + factor * z.1 * z.1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_the_large_bulbs_are_those_whose_orbits_stay() {
        let plain = FractalPattern { magnet: 0, julia: None, iterations: 3000, exponent: 2, exterior: (1, 1.0), interior: (0, 7.0) };
        // Kind 1 of the inside asks for the orbit.
        let asked = FractalPattern { interior: (1, 7.0), exterior: (0, -1.0), ..plain };
        let mut n_inside = 0;
        for i in 0..120 {
            for j in 0..60 {
                let p = DVec3::new(f64::from(i) * 0.025 - 2.2, f64::from(j) * 0.02 + 1e-4, 0.0);
                if is_in_large_bulbs(C(p.x, p.y)) {
                    n_inside += 1;
                    assert_eq!(fractal(&plain, p), 7.0);
                    assert!(fractal(&asked, p) >= 0.0, "{p} escapes");
                }
            }
        }
        assert!(n_inside > 1000);
    }

    #[test]
    fn a_cycle_is_found_with_its_period_and_once() {
        let mut cycle = Cycle { saved: C(-1.0, 0.0), age: 0, limit: 8, found: false };
        let found: Vec<_> = (0..100).filter_map(|k| cycle.look(C(f64::from(if k < 20 { 100 + k } else { k % 7 }), 0.0))).collect();
        assert_eq!(found, [7]);
    }
}
