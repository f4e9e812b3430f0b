//! The scene's statements, `#default`, and the values of declarations that are no numbers. Source: spec/language.md, section 6.

use super::{PResult, Parser};
use crate::lang::keyword::Kw;
use crate::lang::token::{Punct, TokenKind};
use crate::lang::value::Value;
use crate::scene::{Csg, Object, Scene, Shape};
use std::sync::Arc;

impl Parser<'_> {
    /// Statements up to the end of the scene.
    pub(super) fn parse_statements(&mut self) -> PResult<()> {
        loop {
            let t = self.peek()?;
            if t.kind == TokenKind::Eof {
                self.last_span = t.span;
                if let Some(open) = self.conds.last() {
                    let span = open.span;
                    let mut e = self.error("End of file reached but #end expected.");
                    e.trace.push(crate::diag::TraceEntry { what: "for the directive that stands here".into(), span });
                    return Err(e);
                }
                return Ok(());
            }
            self.parse_statement()?;
        }
    }

    fn parse_statement(&mut self) -> PResult<()> {
        let t = self.peek()?;
        if let Some(Value::Object(_)) = self.peek_value()? {
            let object = self.parse_object()?.expect("an object's name is next");
            return self.place(object);
        }
        let TokenKind::Kw(k) = t.kind else { return self.expected("object or directive") };
        match k {
            Kw::Camera => {
                self.next()?;
                let camera = self.parse_camera()?;
                if self.camera_set {
                    self.warn("More than one camera in scene. Ignoring previous camera(s).");
                }
                self.camera_set = true;
                self.scene.camera = camera;
                Ok(())
            }
            Kw::LightSource => {
                self.next()?;
                let light = self.parse_light()?;
                self.scene.lights.push(light);
                Ok(())
            }
            Kw::Fog => {
                self.next()?;
                let fog = self.parse_fog()?;
                if fog.distance != 0.0 {
                    self.scene.fogs.push(fog);
                }
                Ok(())
            }
            Kw::Rainbow => {
                self.next()?;
                let r = self.parse_rainbow()?;
                // One without colours, width or distance is not there.
                if !r.color_map.entries.is_empty() && r.width_rad != 0.0 && r.distance != 0.0 {
                    self.scene.rainbows.push(r);
                }
                Ok(())
            }
            Kw::SkySphere => {
                self.next()?;
                let s = self.parse_sky_sphere()?;
                if self.scene.sky_sphere.is_some() {
                    self.warn("Only one sky-sphere allowed (last one will be used).");
                }
                self.scene.sky_sphere = Some(s);
                Ok(())
            }
            Kw::Media => {
                self.next()?;
                let m = self.parse_media()?;
                self.scene.atmosphere.extend(m);
                Ok(())
            }
            Kw::Background => {
                self.next()?;
                let at_end = |p: &mut Self| p.at_punct(Punct::RBrace);
                let c = self.block("background", |p| if at_end(p)? { Ok(Default::default()) } else { p.parse_color() })?;
                self.scene.background = c;
                if self.version < 370 {
                    // Output with alpha (+UA) sees through it, whatever its colour (measured).
                    self.scene.background.filter = 0.0;
                    self.scene.background.transmit = 1.0;
                }
                Ok(())
            }
            Kw::GlobalSettings => {
                self.next()?;
                self.parse_global_settings()
            }
            Kw::MaxTraceLevel => {
                self.next()?;
                self.warn("Possible Parse Error: 'max_trace_level' should be in global_settings.");
                self.scene.settings.max_trace_level = self.parse_int()?.clamp(1, 256) as u32;
                Ok(())
            }
            Kw::MaxIntersections => {
                self.next()?;
                self.parse_float().map(|_| ())
            }
            Kw::Declare | Kw::Include | Kw::Default => {
                // Old scenes leave the # out.
                self.next()?;
                self.warn(format!("Should have '#' before '{}'.", k.text()));
                if k == Kw::Declare {
                    self.warn("Possible Parse Error: 'declare' should be changed to '#declare'.");
                }
                match k {
                    Kw::Declare => self.declare(false),
                    Kw::Default => self.default_directive(),
                    _ => {
                        let name = self.parse_file_name()?;
                        let span = self.last_span;
                        self.include_file(&name, Some(span))
                    }
                }
            }
            Kw::Version => {
                // The rest of the file is ignored, silently, as POV-Ray does.
                while self.next_raw().kind != TokenKind::Eof {}
                Ok(())
            }
            _ => match self.parse_object()? {
                Some(object) => self.place(object),
                None => self.expected("object or directive"),
            },
        }
    }

    /// Puts an object into the scene: what has no cover yet takes the present default.
    fn place(&mut self, mut object: Object) -> PResult<()> {
        self.n_objects += 1;
        if self.n_objects > self.options.max_objects {
            return Err(self.error(format!("The scene has more than {} objects.", self.options.max_objects)));
        }
        if let Shape::Light(mut light) = object.shape {
            light.transform(&object.transform);
            self.scene.lights.push(*light);
            return Ok(());
        }
        if object.texture.is_none() && object.flags.cutaway_textures != Some(true) {
            object.texture = Some(self.defaults.texture());
        }
        self.warn_of_bounds(&object);
        self.scene.objects.push(object);
        Ok(())
    }

    /// Bounds of simple objects and of unions that are taken apart do nothing.
    fn warn_of_bounds(&mut self, object: &Object) {
        if object.bounded_by.is_empty() {
            return;
        }
        let mut kind = object;
        while let Shape::Group { child } = &kind.shape {
            kind = child;
        }
        match &kind.shape {
            Shape::Csg { op: Csg::Union, .. } | Shape::Text { .. } => {
                let is_whole = !object.clipped_by.is_empty() || object.flags.inverse || object.flags.split_union == Some(false);
                if !is_whole {
                    self.warn("CSG union unnecessarily bounded.");
                }
            }
            Shape::Csg { .. } | Shape::Poly { .. } | Shape::LightGroup { .. } | Shape::Light(_) => {}
            _ => self.warn("Unnecessary bounding object removed."),
        }
    }

    /// What the statements say together.
    pub(super) fn finish_scene(&mut self) -> PResult<Scene> {
        let mut scene = std::mem::take(&mut self.scene);
        if scene.objects.is_empty() && scene.lights.is_empty() {
            self.warn("No objects in scene.");
        }
        if !self.camera_set {
            scene.camera = self.defaults.camera.clone();
        }
        if !self.version_set {
            self.warn_of_scene("This scene did not contain a #version directive: it is treated as one of version 3.62.");
        } else if self.version_late {
            self.warn_of_scene(
                "This scene had other declarations preceding the first #version directive: what was declared before it \
                 was read as version 3.7. Make #version the first declaration of the scene.",
            );
        }
        if self.version_set && self.version < 350 {
            self.warn_of_scene(format!(
                "The scene ends as one of language version {}: POV-Ray's defects of that time are not all reproduced.",
                f64::from(self.version) / 100.0
            ));
        }
        scene.settings.version = if self.version_set { self.version } else { 362 };
        if !self.gamma_set {
            use crate::scene::settings::WorkingGamma;
            if scene.settings.version < 370 && self.options.version.is_some_and(|v| v >= 370) {
                self.warn_of_scene(
                    "Version 3.7 was asked for outside the scene, which says itself that it is older, and assumed_gamma is not specified: \
                     1.0 is taken.",
                );
                scene.settings.gamma = WorkingGamma::Linear;
            } else if scene.settings.version < 370 {
                self.warn_of_scene("assumed_gamma not specified: gamma correction is off, as in POV-Ray before version 3.7.");
                scene.settings.gamma = WorkingGamma::None;
            } else {
                self.warn_of_scene(
                    "Possible Parse Error: assumed_gamma not specified in this scene of version 3.7: 1.0 is taken. \
                     Say 'assumed_gamma 1.0' in global_settings.",
                );
                scene.settings.gamma = WorkingGamma::Linear;
            }
        }
        if let Some(p) = &mut scene.settings.photons {
            if p.adc_bailout.is_nan() {
                p.adc_bailout = scene.settings.adc_bailout;
            }
            if p.max_trace_level == 0 {
                p.max_trace_level = scene.settings.max_trace_level;
            }
        }
        if let Some(r) = &mut scene.settings.radiosity {
            r.importance = self.defaults.importance;
            if r.pretrace.1 > r.pretrace.0 {
                return Err(self.error("radiosity pretrace_end must be smaller than or equal to pretrace_start."));
            }
        }
        Ok(scene)
    }

    /// `#default { ... }`.
    pub(super) fn default_directive(&mut self) -> PResult<()> {
        self.opened(|p| {
            p.block("default", |p| {
                while let Some(k) = p.peek_kw()? {
                    match k {
                        Kw::Texture => {
                            p.next()?;
                            p.default_texture()?;
                        }
                        Kw::Pigment => {
                            p.next()?;
                            let start = p.defaults.pigment.clone();
                            p.defaults.pigment = p.pigment_block_from(start)?;
                        }
                        Kw::Normal => {
                            p.next()?;
                            let start = p.defaults.normal.clone();
                            p.defaults.normal = Some(p.normal_block_from(start)?);
                        }
                        Kw::Finish => {
                            p.next()?;
                            let start = p.defaults.finish.clone();
                            p.defaults.finish = p.finish_block_from(start)?.0;
                        }
                        Kw::Camera => {
                            p.next()?;
                            p.defaults.camera = p.parse_camera()?;
                        }
                        Kw::Radiosity => {
                            p.next()?;
                            p.defaults.importance = p.parse_importance()?;
                        }
                        _ => break,
                    }
                }
                Ok(())
            })
        })
    }

    fn default_texture(&mut self) -> PResult<()> {
        let texture = self.parse_texture_block()?;
        let crate::scene::Texture::Layers(layers) = &*texture else {
            return Err(self.error("Default texture cannot be material map or tiles."));
        };
        let [layer] = layers.as_slice() else { return Err(self.error("Default texture cannot be layered.")) };
        self.defaults.pigment = layer.pigment.clone();
        self.defaults.normal = layer.normal.clone();
        self.defaults.finish = layer.finish.clone();
        Ok(())
    }

    /// The value of a declaration that starts with word `k`; `None` when none does.
    pub(super) fn parse_declared(&mut self, k: Kw) -> PResult<Option<Value>> {
        Ok(Some(match k {
            Kw::Function => {
                self.next()?;
                Value::Function(self.parse_function()?)
            }
            Kw::Spline => {
                self.next()?;
                Value::Spline(Arc::new(self.parse_spline()?))
            }
            Kw::Transform => {
                self.next()?;
                Value::Transform(Arc::new(self.parse_transform_block()?))
            }
            Kw::Pigment => {
                self.next()?;
                Value::Pigment(self.parse_pigment_block()?)
            }
            Kw::Density => {
                self.next()?;
                Value::Density(self.parse_density_block()?)
            }
            Kw::Normal => {
                self.next()?;
                Value::Normal(self.parse_normal_block()?)
            }
            Kw::Finish => {
                self.next()?;
                let start = self.defaults.finish.clone();
                let (f, extras) = self.finish_block_from(start)?;
                Value::Finish(f, Arc::new(extras))
            }
            Kw::Texture => self.parse_declared_textures()?,
            Kw::Material => {
                self.next()?;
                Value::Material(Arc::new(self.parse_material()?))
            }
            Kw::Interior => {
                self.next()?;
                Value::Interior(Arc::new(self.parse_interior(None)?))
            }
            Kw::Media => {
                self.next()?;
                Value::Media(Arc::new(self.parse_media()?))
            }
            Kw::ColorMap => {
                self.next()?;
                Value::ColorMap(self.parse_color_map()?)
            }
            Kw::PigmentMap => {
                self.next()?;
                Value::PigmentMap(self.parse_pigment_map(k, true)?)
            }
            Kw::DensityMap => {
                self.next()?;
                Value::DensityMap(self.parse_pigment_map(k, true)?)
            }
            Kw::NormalMap => {
                self.next()?;
                Value::NormalMap(self.parse_normal_map(true)?)
            }
            Kw::SlopeMap => {
                self.next()?;
                Value::SlopeMap(self.parse_slope_map()?)
            }
            Kw::TextureMap => {
                self.next()?;
                Value::TextureMap(self.parse_texture_map(true)?)
            }
            Kw::Camera => {
                self.next()?;
                Value::Camera(Arc::new(self.parse_camera()?))
            }
            Kw::Fog => {
                self.next()?;
                Value::Fog(Arc::new(self.parse_fog()?))
            }
            Kw::Rainbow => {
                self.next()?;
                Value::Rainbow(Arc::new(self.parse_rainbow()?))
            }
            Kw::SkySphere => {
                self.next()?;
                Value::SkySphere(Arc::new(self.parse_sky_sphere()?))
            }
            Kw::LightSource => {
                self.next()?;
                let light = self.parse_light()?;
                Value::Object(Arc::new(Object::new(Shape::Light(Box::new(light)))))
            }
            _ => match self.parse_object()? {
                Some(o) => Value::Object(Arc::new(Self::shared(o))),
                None => return Ok(None),
            },
        }))
    }

    /// One or more texture blocks or names: layers of one texture.
    pub(super) fn parse_declared_textures(&mut self) -> PResult<Value> {
        let mut texture = None;
        loop {
            if self.accept_kw(Kw::Texture)? {
                let t = self.parse_texture_block()?;
                texture = Some(self.layer_texture(texture, t)?);
            } else if texture.is_none()
                && let Some(Value::Texture(t)) = self.peek_value()?
            {
                let t = t.clone();
                self.next()?;
                texture = Some(t);
            } else {
                return Ok(Value::Texture(texture.expect("the first token was a texture")));
            }
            if !self.in_text_kw(Kw::Texture) {
                return Ok(Value::Texture(texture.expect("just set")));
            }
        }
    }

    /// Whether the next token in the text is this word, without running directives that stand before it.
    fn in_text_kw(&self, k: Kw) -> bool {
        if let Some(t) = self.ahead {
            return t.kind == TokenKind::Kw(k);
        }
        let f = self.frames.last().expect("a frame");
        f.at < f.end && f.tokens[f.at].kind == TokenKind::Kw(k)
    }
}
