//! Complex numbers, as many as julia fractals need.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// re + im i.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Complex {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
}

impl Complex {
    /// 1.
    pub const ONE: Complex = Complex { re: 1.0, im: 0.0 };
    /// i.
    pub const I: Complex = Complex { re: 0.0, im: 1.0 };

    /// From its parts.
    pub fn new(re: f64, im: f64) -> Self {
        Self { re, im }
    }

    /// Times a real number.
    #[must_use]
    pub fn scale(self, k: f64) -> Self {
        Self::new(self.re * k, self.im * k)
    }

    /// e to it.
    #[must_use]
    pub fn exp(self) -> Self {
        let r = self.re.exp();
        Self::new(r * self.im.cos(), r * self.im.sin())
    }

    /// Principal logarithm.
    #[must_use]
    pub fn ln(self) -> Self {
        Self::new(self.re.hypot(self.im).ln(), self.im.atan2(self.re))
    }

    /// Principal root.
    #[must_use]
    pub fn sqrt(self) -> Self {
        let r = self.re.hypot(self.im);
        let re = (0.5 * (r + self.re)).max(0.0).sqrt();
        let im = (0.5 * (r - self.re)).max(0.0).sqrt();
        Self::new(re, if self.im < 0.0 { -im } else { im })
    }

    /// To a complex power.
    #[must_use]
    pub fn powc(self, p: Complex) -> Self {
        if self == Self::default() { Self::default() } else { (self.ln() * p).exp() }
    }

    /// Sine.
    #[must_use]
    pub fn sin(self) -> Self {
        Self::new(self.re.sin() * self.im.cosh(), self.re.cos() * self.im.sinh())
    }

    /// Cosine.
    #[must_use]
    pub fn cos(self) -> Self {
        Self::new(self.re.cos() * self.im.cosh(), -self.re.sin() * self.im.sinh())
    }

    /// Hyperbolic sine.
    #[must_use]
    pub fn sinh(self) -> Self {
        Self::new(self.re.sinh() * self.im.cos(), self.re.cosh() * self.im.sin())
    }

    /// Hyperbolic cosine.
    #[must_use]
    pub fn cosh(self) -> Self {
        Self::new(self.re.cosh() * self.im.cos(), self.re.sinh() * self.im.sin())
    }

    /// Arcsine.
    #[must_use]
    pub fn asin(self) -> Self {
        let s = (Self::ONE - self * self).sqrt();
        -Self::I * (Self::I * self + s).ln()
    }

    /// Arccosine.
    #[must_use]
    pub fn acos(self) -> Self {
        Self::new(std::f64::consts::FRAC_PI_2, 0.0) - self.asin()
    }

    /// Inverse hyperbolic sine.
    #[must_use]
    pub fn asinh(self) -> Self {
        (self + (self * self + Self::ONE).sqrt()).ln()
    }

    /// Inverse hyperbolic cosine.
    #[must_use]
    pub fn acosh(self) -> Self {
        (self + (self + Self::ONE).sqrt() * (self - Self::ONE).sqrt()).ln()
    }

    /// Arctangent.
    #[must_use]
    pub fn atan(self) -> Self {
        let iz = Self::I * self;
        -Self::I.scale(0.5) * ((Self::ONE + iz) / (Self::ONE - iz)).ln()
    }

    /// Inverse hyperbolic tangent.
    #[must_use]
    pub fn atanh(self) -> Self {
        ((Self::ONE + self) / (Self::ONE - self)).ln().scale(0.5)
    }
}

impl Add for Complex {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self::new(self.re + o.re, self.im + o.im)
    }
}

impl Sub for Complex {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self::new(self.re - o.re, self.im - o.im)
    }
}

impl Mul for Complex {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Self::new(self.re * o.re - self.im * o.im, self.re * o.im + self.im * o.re)
    }
}

impl Div for Complex {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let d = o.re * o.re + o.im * o.im;
        Self::new((self.re * o.re + self.im * o.im) / d, (self.im * o.re - self.re * o.im) / d)
    }
}

impl Neg for Complex {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.re, -self.im)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_functions_undo_the_functions() {
        let z = Complex::new(0.3, -0.4);
        let near = |a: Complex| ((a - z).re.abs() + (a - z).im.abs()) < 1e-12;
        assert!(near(z.sin().asin()) && near(z.asin().sin()) && near(z.acos().cos()) && near(z.sinh().asinh()) && near(z.acosh().cosh()));
        assert!(near((z.sin() / z.cos()).atan()) && near((z.sinh() / z.cosh()).atanh()) && near(z.exp().ln()) && near(z.sqrt() * z.sqrt()));
        assert!(near(z.powc(Complex::new(3.0, 0.0)).powc(Complex::new(1.0 / 3.0, 0.0))));
    }
}
