//! `global_settings`. Source: spec/language.md, section 6.1.

use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::token::TokenKind;
use crate::scene::settings::{Photons, WorkingGamma};

impl Parser<'_> {
    pub(super) fn parse_global_settings(&mut self) -> PResult<()> {
        self.block("global_settings", |p| {
            while let Some(k) = p.peek_kw()? {
                match k {
                    Kw::AssumedGamma => {
                        p.next()?;
                        p.assumed_gamma()?;
                    }
                    Kw::AdcBailout => {
                        p.next()?;
                        p.scene.settings.adc_bailout = p.parse_float()?;
                    }
                    Kw::AmbientLight => {
                        p.next()?;
                        p.scene.settings.ambient_light = p.parse_rgb()?;
                    }
                    Kw::IridWavelength => {
                        p.next()?;
                        p.scene.settings.irid_wavelength = p.parse_rgb()?;
                    }
                    Kw::MaxTraceLevel => {
                        p.next()?;
                        let n = p.parse_int()?;
                        if n > 256 {
                            p.warn("Maximum max_trace_level is 256.");
                        }
                        p.scene.settings.max_trace_level = n.clamp(1, 256) as u32;
                    }
                    Kw::MaxIntersections => {
                        p.next()?;
                        p.parse_float()?;
                        p.warn("'max_intersections' is no longer needed.");
                    }
                    Kw::HfGray16 => {
                        p.next()?;
                        p.parse_switch()?;
                        p.warn("In POV-Ray v3.7 'hf_gray_16' has no effect on the output file type.");
                    }
                    Kw::MmPerUnit => {
                        p.next()?;
                        p.scene.settings.mm_per_unit = p.parse_float()?;
                    }
                    Kw::NoiseGenerator => {
                        p.next()?;
                        let n = p.parse_noise_generator()?;
                        if n == 0 {
                            return Err(p.error("Value for noise_generator in global_settings must be 1, 2, or 3."));
                        }
                        p.scene.settings.noise_generator = n;
                        p.noise_set = true;
                        p.noise_changed();
                    }
                    Kw::NumberOfWaves => {
                        p.next()?;
                        let n = p.parse_int()?;
                        if n < 1 {
                            p.warn("Illegal Value: number_of_waves must be at least 1. Changed to 1.");
                        }
                        p.scene.settings.number_of_waves = p.at_most(n.max(1), 10_000, "number_of_waves")?;
                        p.noise_changed();
                    }
                    Kw::Charset => {
                        p.next()?;
                        let t = p.next()?;
                        match t.kind {
                            TokenKind::Kw(Kw::Ascii) => p.utf8 = false,
                            TokenKind::Kw(Kw::Utf8 | Kw::Sys) => p.utf8 = true,
                            _ => return Err(p.expected_instead("charset type", t)),
                        }
                    }
                    Kw::Photons => {
                        p.next()?;
                        p.parse_photon_settings()?;
                    }
                    Kw::Radiosity => {
                        p.next()?;
                        p.parse_radiosity()?;
                    }
                    Kw::Subsurface => {
                        p.next()?;
                        p.parse_subsurface_settings()?;
                    }
                    _ => break,
                }
            }
            Ok(())
        })
    }

    fn assumed_gamma(&mut self) -> PResult<()> {
        let gamma = if self.accept_kw(Kw::Srgb)? {
            WorkingGamma::Srgb
        } else {
            let g = self.parse_float()?;
            if g <= 0.0 {
                return Err(self.error("Invalid assumed_gamma value. Must be a positive number."));
            }
            if g < 1.0 {
                self.warn("Possible Parse Error: Suspicious value for 'assumed_gamma'.");
            }
            if (g - 1.0).abs() < 1e-6 { WorkingGamma::Linear } else { WorkingGamma::Power(g) }
        };
        if self.gamma_set {
            self.warn("New instance of 'assumed_gamma' ignored.");
            return Ok(());
        }
        self.gamma_set = true;
        self.scene.settings.gamma = gamma;
        Ok(())
    }

    /// After a change of what noise is made of: the settings, or the language version where the settings say nothing (measured: the
    /// version in force decides, below 3.5 it is generator 1).
    pub(super) fn noise_changed(&mut self) {
        if !self.noise_set {
            self.scene.settings.noise_generator = if self.version < 350 { 1 } else { 2 };
        }
        self.query.use_noise(self.scene.settings.noise_generator, self.scene.settings.number_of_waves);
    }

    pub(super) fn parse_noise_generator(&mut self) -> PResult<u8> {
        let n = self.parse_int()?;
        if !(0..=3).contains(&n) {
            return Err(self.error(format!("Value {n} for noise_generator is out of range (0 to 3).")));
        }
        Ok(n as u8)
    }

    fn parse_subsurface_settings(&mut self) -> PResult<()> {
        let mut s = self.scene.settings.subsurface.unwrap_or((50, 50, false));
        self.block("subsurface", |p| {
            while let Some(k) = p.peek_kw()? {
                match k {
                    Kw::Samples => {
                        p.next()?;
                        s.0 = p.parse_int()?.clamp(0, 1 << 20) as u32;
                        p.comma()?;
                        s.1 = p.parse_int()?.clamp(0, 1 << 20) as u32;
                    }
                    Kw::Radiosity => {
                        p.next()?;
                        s.2 = p.parse_float()? > 0.0;
                    }
                    _ => break,
                }
            }
            Ok(())
        })?;
        self.scene.settings.subsurface = Some(s);
        Ok(())
    }

    fn parse_photon_settings(&mut self) -> PResult<()> {
        let mut s = self.scene.settings.photons.clone().unwrap_or_else(|| Photons {
            // The scene's own, which may be set later still, unless given here: see `finish_scene`.
            adc_bailout: f64::NAN,
            max_trace_level: 0,
            ..Photons::default()
        });
        self.block("photons", |p| {
            while let Some(k) = p.peek_kw()? {
                p.next()?;
                match k {
                    Kw::Radius => {
                        for r in &mut s.radius {
                            if !p.number_follows()? {
                                break;
                            }
                            *r = p.parse_float()?;
                            p.comma()?;
                        }
                    }
                    Kw::Spacing => s.spacing = p.parse_float()?,
                    Kw::Count => s.count = p.parse_int()?.clamp(0, i64::from(u32::MAX)) as u32,
                    Kw::Gather => {
                        s.gather.0 = p.parse_int()?.clamp(0, 1 << 20) as u32;
                        p.comma()?;
                        s.gather.1 = p.parse_int()?.clamp(0, 1 << 20) as u32;
                        if s.gather.0 > s.gather.1 {
                            return Err(p.error("min_gather_count must be less than max_gather_count."));
                        }
                    }
                    Kw::Jitter => s.jitter = p.parse_float()?,
                    Kw::Autostop => s.autostop = p.parse_float()?,
                    Kw::ExpandThresholds => {
                        s.expand.0 = p.parse_float()?;
                        p.comma()?;
                        s.expand.1 = p.parse_int()?.clamp(0, 1 << 20) as u32;
                    }
                    Kw::AdcBailout => s.adc_bailout = p.parse_float()?,
                    Kw::MaxTraceLevel => s.max_trace_level = p.parse_int()?.clamp(1, 256) as u32,
                    Kw::Media => {
                        let n = p.parse_int()?;
                        if n < 0 {
                            return Err(p.error("max media steps must be non-negative."));
                        }
                        s.media.0 = n.min(1 << 20) as u32;
                        p.comma()?;
                        if p.number_follows()? {
                            s.media.1 = p.parse_float()?;
                        }
                    }
                    Kw::LoadFile | Kw::SaveFile => {
                        p.parse_file_name()?;
                        p.warn_once("photon files", "photon maps are neither loaded nor saved");
                    }
                    _ => return Err(p.error(format!("No matching }} in 'photons', {} found instead", k.text()))),
                }
            }
            Ok(())
        })?;
        self.scene.settings.photons = (s.gather.1 > 0).then_some(s);
        Ok(())
    }

    fn parse_radiosity(&mut self) -> PResult<()> {
        let mut s = self.scene.settings.radiosity.clone().unwrap_or_default();
        let (mut min_given, mut max_given) = (false, false);
        self.block("radiosity", |p| {
            while let Some(k) = p.peek_kw()? {
                p.next()?;
                match k {
                    Kw::PretraceStart => s.pretrace.0 = p.radiosity_number("pretrace_start", 1e-9, 1.0)?,
                    Kw::PretraceEnd => s.pretrace.1 = p.radiosity_number("pretrace_end", 1e-9, 1.0)?,
                    Kw::Count => {
                        s.count = p.radiosity_number("count", 1e-9, 1e9)?;
                        s.pool = (s.count as u32).max(1600);
                        p.comma()?;
                        if p.number_follows()? {
                            s.pool = p.radiosity_number("count", s.count, 1e9)? as u32;
                        }
                    }
                    Kw::ErrorBound => s.error_bound = p.radiosity_number("error_bound", 1e-12, f64::INFINITY)?,
                    Kw::GrayThreshold => s.gray_threshold = p.radiosity_number("gray_threshold", 0.0, 1.0)?,
                    Kw::LowErrorFactor => s.low_error_factor = p.radiosity_number("low_error_factor", 1e-12, f64::INFINITY)?,
                    Kw::MaximumReuse => {
                        s.maximum_reuse = p.radiosity_number("maximum_reuse", 1e-12, f64::INFINITY)?;
                        max_given = true;
                    }
                    Kw::MinimumReuse => {
                        s.minimum_reuse = p.radiosity_number("minimum_reuse", 0.0, 1.0)?;
                        min_given = true;
                    }
                    Kw::NearestCount => {
                        s.nearest_count = (p.radiosity_number("nearest_count", 1.0, 20.0)? as u32, 0);
                        p.comma()?;
                        if p.number_follows()? {
                            s.nearest_count.1 = p.radiosity_number("nearest_count", 0.0, f64::from(s.nearest_count.0) - 1.0)? as u32;
                        }
                    }
                    Kw::RecursionLimit => s.recursion_limit = p.radiosity_number("recursion_limit", 1.0, 20.0)? as u32,
                    Kw::MaxSample => s.max_sample = p.parse_float()?,
                    Kw::AdcBailout => s.adc_bailout = p.radiosity_number("adc_bailout", f64::MIN_POSITIVE, f64::INFINITY)?,
                    Kw::Brightness => s.brightness = p.radiosity_number("brightness", f64::MIN_POSITIVE, f64::INFINITY)?,
                    Kw::AlwaysSample => s.always_sample = p.parse_float()? > 0.0,
                    Kw::Normal => s.normal = p.parse_float()? > 0.0,
                    Kw::Media => s.media = p.parse_float()? > 0.0,
                    Kw::Subsurface => s.subsurface = p.parse_float()? > 0.0,
                    Kw::LoadFile | Kw::SaveFile => {
                        p.parse_file_name()?;
                        p.warn("Possible Parse Error: load_file and save_file in radiosity are ignored; use the command line.");
                    }
                    _ => return Err(p.error(format!("No matching }} in 'radiosity', {} found instead", k.text()))),
                }
            }
            Ok(())
        })?;
        if s.minimum_reuse > s.maximum_reuse / 2.0 && !(min_given && max_given) {
            if max_given {
                s.minimum_reuse = s.maximum_reuse / 2.0;
            } else {
                s.maximum_reuse = s.minimum_reuse * 2.0;
            }
            self.warn("Adjusted radiosity's minimum_reuse and maximum_reuse to each other.");
        }
        if s.minimum_reuse >= s.maximum_reuse {
            return Err(self.error("Radiosity minimum_reuse must be smaller than maximum_reuse."));
        }
        self.scene.settings.radiosity = Some(s);
        Ok(())
    }

    fn radiosity_number(&mut self, what: &str, low: f64, high: f64) -> PResult<f64> {
        let x = self.parse_float()?;
        if !(x >= low && x <= high) {
            return Err(self.error(format!("Radiosity {what} is out of range.")));
        }
        Ok(x)
    }

    /// `{ importance f }` after `radiosity`.
    pub(super) fn parse_importance(&mut self) -> PResult<f64> {
        self.block("radiosity", |p| {
            let mut importance = 1.0;
            while p.accept_kw(Kw::Importance)? {
                importance = p.parse_float()?;
                if !(importance > 0.0 && importance <= 1.0) {
                    return Err(p.error("Radiosity importance must be greater than 0 and at most 1."));
                }
            }
            Ok(importance)
        })
    }
}
