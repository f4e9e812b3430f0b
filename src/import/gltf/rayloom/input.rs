//! Inputs of closures: constants, and the few nodes that give values (docs/RAYLOOM_scene.md, "Textures and values").

use super::super::super::ImportError;
use super::Extension;
use super::record::Record;
use crate::diag::Sink;
use crate::math::{Rgb, Vec3};
use crate::scene::input::{Channel, Color, NormalInput, Picture, Scalar};
use crate::scene::material::{MaterialTexture, Texels, Wrap};
use crate::scene::volume::Density;
use serde_json::Value;

/// Weights of a colour that becomes a number.
const LUMINANCE: Vec3 = Vec3::new(0.212_672_9, 0.715_152_2, 0.072_175);
/// Deepest chain of value nodes.
const MAX_DEPTH: u32 = 64;

/// What an input says.
enum Given {
    Number(f32),
    Color(Rgb),
    Link { node: usize, output: String },
}

/// The nodes of one material or world.
pub(super) struct Inputs<'a, 'e, 's> {
    pub nodes: Vec<Record<'a>>,
    pub extension: &'e mut Extension<'a>,
    pub sink: &'s mut Sink,
    /// "material 'Brick'".
    pub owner: String,
    /// The mesh's set of coordinates that stands first in the scene's mesh.
    pub first_uv: u32,
}

impl<'a> Inputs<'a, '_, '_> {
    /// The kind of node `ix`.
    pub fn kind(&self, ix: usize) -> Result<&'a str, ImportError> {
        self.nodes[ix].needed("type", self.nodes[ix].text("type")?)
    }

    fn given(&self, r: &Record<'a>, key: &str) -> Result<Option<Given>, ImportError> {
        let Some(value) = r.get(key) else { return Ok(None) };
        Ok(Some(match value {
            Value::Object(_) => {
                let link = r.record(key)?.expect("it is an object");
                let node = link.needed("node", link.index("node", self.nodes.len(), "shader node")?)?;
                let output = link.text("output")?.unwrap_or_default().to_owned();
                link.finish()?;
                Given::Link { node, output }
            }
            Value::Array(_) => {
                let c = r.numbers::<3>(key)?.expect("it is there");
                Given::Color(Vec3::from(c.map(|v| v as f32)))
            }
            _ => Given::Number(r.number(key)?.expect("it is there") as f32),
        }))
    }

    /// An input that wants a number.
    pub fn scalar(&mut self, ix: usize, key: &str, default: f32) -> Result<Scalar, ImportError> {
        self.scalar_at(ix, key, default, 0)
    }

    fn scalar_at(&mut self, ix: usize, key: &str, default: f32, depth: u32) -> Result<Scalar, ImportError> {
        match self.given(&self.nodes[ix], key)? {
            None => Ok(default.into()),
            Some(Given::Number(v)) => Ok(v.into()),
            Some(Given::Color(c)) => Ok(c.dot(LUMINANCE).into()),
            Some(Given::Link { node, output }) => {
                self.check_order(ix, key, node, depth)?;
                Ok(self.linked_scalar(node, &output, depth + 1)?.unwrap_or_else(|| default.into()))
            }
        }
    }

    /// Nodes stand before those that use them, so there is no circle.
    fn check_order(&self, ix: usize, key: &str, node: usize, depth: u32) -> Result<(), ImportError> {
        if node >= ix {
            return Err(self.nodes[ix].wrong(key, format!("it names node {node}, which does not stand before node {ix}")));
        }
        if depth >= MAX_DEPTH {
            return Err(self.nodes[ix].wrong(key, format!("nodes hang on each other deeper than {MAX_DEPTH}")));
        }
        Ok(())
    }

    fn linked_scalar(&mut self, node: usize, output: &str, depth: u32) -> Result<Option<Scalar>, ImportError> {
        let kind = self.kind(node)?;
        let through = |picture, channel| Scalar { factor: 1.0, offset: 0.0, picture: Some((picture, channel)) };
        Ok(match kind {
            "image" => {
                let channel = if output == "alpha" { Channel::Alpha } else { Channel::Luminance };
                self.picture(node, output == "alpha")?.map_or_else(|| missing(channel), |p| Some(through(p, channel)))
            }
            "separate" => {
                let channel = match output {
                    "x" => Channel::Red,
                    "y" => Channel::Green,
                    _ => Channel::Blue,
                };
                match self.given(&self.nodes[node], "color")? {
                    Some(Given::Link { node: image, .. }) if self.kind(image)? == "image" => {
                        self.check_order(node, "color", image, depth)?;
                        self.picture(image, false)?.map_or_else(|| missing(channel), |p| Some(through(p, channel)))
                    }
                    Some(Given::Color(c)) => Some([c.x, c.y, c.z][channel as usize].into()),
                    Some(Given::Number(v)) => Some(v.into()),
                    _ => {
                        self.told("a channel of something else than a picture is left out");
                        None
                    }
                }
            }
            "math" => self.math(node, depth)?,
            other => {
                self.told(&format!("a number made by '{other}' is left out"));
                None
            }
        })
    }

    /// A line: sums and products of which one term varies.
    fn math(&mut self, node: usize, depth: u32) -> Result<Option<Scalar>, ImportError> {
        let operation = self.nodes[node].text("operation")?.unwrap_or("add");
        let clamp = self.nodes[node].flag("clamp", false)?;
        let a = self.scalar_at(node, "a", 0.5, depth)?;
        let b = self.scalar_at(node, "b", 0.5, depth)?;
        let out = match (operation, a.as_constant(), b.as_constant()) {
            ("add", Some(c), _) => line(b, 1.0, c),
            ("add", _, Some(c)) => line(a, 1.0, c),
            ("subtract", _, Some(c)) => line(a, 1.0, -c),
            ("subtract", Some(c), _) => line(b, -1.0, c),
            ("multiply", Some(c), _) => line(b, c, 0.0),
            ("multiply", _, Some(c)) => line(a, c, 0.0),
            ("divide", _, Some(c)) if c != 0.0 => line(a, 1.0 / c, 0.0),
            ("multiply_add", Some(f), _) => {
                let c = self.scalar_at(node, "c", 0.5, depth)?;
                match c.as_constant() {
                    Some(d) => line(b, f, d),
                    None if b.as_constant().is_some() => line(c, 1.0, f * b.as_constant().unwrap_or(0.0)),
                    None => return Ok(self.no_line(operation)),
                }
            }
            ("multiply_add", _, Some(f)) => match self.scalar_at(node, "c", 0.5, depth)?.as_constant() {
                Some(d) => line(a, f, d),
                None => return Ok(self.no_line(operation)),
            },
            _ => return Ok(self.no_line(operation)),
        };
        match out.as_constant() {
            Some(c) if clamp => Ok(Some(c.clamp(0.0, 1.0).into())),
            None if clamp => Ok(self.no_line("clamp")),
            _ => Ok(Some(out)),
        }
    }

    fn no_line(&mut self, operation: &str) -> Option<Scalar> {
        self.told(&format!("the math node '{operation}' of more than one picture is left out"));
        None
    }

    /// An input that wants a colour.
    pub fn color(&mut self, ix: usize, key: &str, default: Vec3) -> Result<Color, ImportError> {
        self.color_at(ix, key, default, 0)
    }

    fn color_at(&mut self, ix: usize, key: &str, default: Vec3, depth: u32) -> Result<Color, ImportError> {
        match self.given(&self.nodes[ix], key)? {
            None => Ok(default.into()),
            Some(Given::Number(v)) => Ok(v.into()),
            Some(Given::Color(c)) => Ok(c.into()),
            Some(Given::Link { node, output }) => {
                self.check_order(ix, key, node, depth)?;
                Ok(self.linked_color(node, &output, depth + 1)?.unwrap_or_else(|| default.into()))
            }
        }
    }

    fn linked_color(&mut self, node: usize, output: &str, depth: u32) -> Result<Option<Color>, ImportError> {
        Ok(match self.kind(node)? {
            "image" if output != "alpha" => match self.picture(node, false)? {
                Some(p) => Some(Color { factor: Vec3::ONE, picture: Some(p), vertex_color: false }),
                None => Some(PINK.into()),
            },
            "attribute" => match self.nodes[node].text("name")? {
                Some("COLOR_0") => Some(Color { factor: Vec3::ONE, picture: None, vertex_color: true }),
                other => {
                    self.told(&format!("the colour attribute '{}' is left out", other.unwrap_or_default()));
                    None
                }
            },
            "mixColor" if self.nodes[node].text("blend")? == Some("multiply") => {
                let factor = self.scalar_at(node, "factor", 1.0, depth)?.as_constant();
                let a = self.color_at(node, "a", Vec3::ONE, depth)?;
                let b = self.color_at(node, "b", Vec3::ONE, depth)?;
                for key in ["clampFactor", "clampResult"] {
                    self.nodes[node].get(key);
                }
                match (factor, a.as_constant(), b.as_constant()) {
                    (Some(1.0), Some(c), _) => Some(Color { factor: c * b.factor, ..b }),
                    (Some(1.0), _, Some(c)) => Some(Color { factor: c * a.factor, ..a }),
                    _ => {
                        self.told("a mix of two pictures is left out");
                        None
                    }
                }
            }
            other => {
                let what = format!("a colour made by '{other}' is left out");
                self.told(&what);
                None
            }
        })
    }

    /// An input that wants a normal.
    pub fn normal(&mut self, ix: usize, key: &str) -> Result<Option<Box<NormalInput>>, ImportError> {
        self.normal_at(ix, key, 0)
    }

    fn normal_at(&mut self, ix: usize, key: &str, depth: u32) -> Result<Option<Box<NormalInput>>, ImportError> {
        let Some(Given::Link { node, .. }) = self.given(&self.nodes[ix], key)? else { return Ok(None) };
        self.check_order(ix, key, node, depth)?;
        match self.kind(node)? {
            "normalMap" => {
                let strength = self.scalar_at(node, "strength", 1.0, depth + 1)?;
                let space = self.nodes[node].text("space")?.unwrap_or("tangent");
                let picture = match self.given(&self.nodes[node], "color")? {
                    Some(Given::Link { node: image, .. }) if self.kind(image)? == "image" && space == "tangent" => {
                        self.check_order(node, "color", image, depth)?;
                        self.picture(image, false)?
                    }
                    _ => {
                        self.told("a normal map that is no picture in tangent space is left out");
                        return Ok(None);
                    }
                };
                Ok(picture.map(|mut picture| {
                    // The picture's own UV set gives the tangents too.
                    picture.texture.srgb &= false;
                    Box::new(NormalInput::Map { picture, strength, scale_xy: false })
                }))
            }
            "bump" => {
                let height = self.scalar_at(node, "height", 0.0, depth + 1)?;
                let strength = self.scalar_at(node, "strength", 1.0, depth + 1)?;
                let distance = self.scalar_at(node, "distance", 1.0, depth + 1)?;
                let invert = self.nodes[node].flag("invert", false)?;
                let base = self.normal_at(node, "normal", depth + 1)?;
                Ok(Some(Box::new(NormalInput::Bump { height, strength, distance, invert, base })))
            }
            other => {
                let what = format!("a normal made by '{other}' is left out");
                self.told(&what);
                Ok(None)
            }
        }
    }

    /// A density: a number, or a grid (with density 1 beside it).
    pub fn density(&mut self, ix: usize, key: &str, default: f32) -> Result<(f32, Option<Density>), ImportError> {
        match self.given(&self.nodes[ix], key)? {
            None => Ok((default, None)),
            Some(Given::Number(v)) => Ok((v, None)),
            Some(Given::Color(c)) => Ok((c.dot(LUMINANCE), None)),
            Some(Given::Link { node, .. }) if self.kind(node)? == "grid" => {
                let grid = self.nodes[node].index("grid", self.extension.grids.len(), "grid")?;
                let grid = self.nodes[node].needed("grid", grid)?;
                Ok((1.0, Some(super::grid::density(&self.extension.grids[grid])?)))
            }
            Some(Given::Link { .. }) => {
                self.told("a density that is no grid is left out");
                Ok((default, None))
            }
        }
    }

    /// What the node that a colour comes from is, if it comes from one.
    pub fn source(&self, ix: usize, key: &str) -> Result<Option<usize>, ImportError> {
        match self.given(&self.nodes[ix], key)? {
            Some(Given::Link { node, .. }) => self.check_order(ix, key, node, 0).map(|()| Some(node)),
            _ => Ok(None),
        }
    }

    /// The picture of an image node; `None` where it cannot be read.
    fn picture(&mut self, node: usize, alpha: bool) -> Result<Option<Picture>, ImportError> {
        let r = &self.nodes[node];
        let ix = r.needed("image", r.index("image", self.extension.pictures.len(), "picture")?)?;
        let interpolation = r.text("interpolation")?.unwrap_or("linear");
        let wraps = [("repeat", Wrap::Repeat), ("extend", Wrap::Clamp), ("clip", Wrap::Clip), ("mirror", Wrap::Mirror)];
        let wrap = r.choice("extension", Wrap::Repeat, &wraps)?;
        let projection = r.text("projection")?.unwrap_or("flat");
        r.get("blend");
        let (mut uv_set, mut affine, mut source) = (0, None, "uv");
        if let Some(c) = r.record("coordinates")? {
            source = c.text("source")?.unwrap_or("uv");
            uv_set = c.count_or("uvSet", 0)?;
            affine = c.numbers::<12>("affine")?;
            c.finish()?;
        }
        if source != "uv" || projection != "flat" {
            self.told(&format!("a picture projected {projection} along '{source}' is laid over UV"));
        }
        if matches!(interpolation, "cubic" | "smart") {
            self.told("cubic interpolation of pictures is linear");
        }
        let Some(d) = self.extension.pictures.decoded(ix, self.sink) else { return Ok(None) };
        if alpha && d.ignores_alpha {
            return Ok(None);
        }
        let filter_encoded = d.srgb && matches!(d.image.texels, Texels::Rgba8(_));
        let texture = MaterialTexture {
            image: d.image,
            srgb: d.srgb,
            wrap: [wrap; 2],
            linear: interpolation != "closest",
            uv_transform: uv_transform(affine),
        };
        let uv_set = place_of_set(uv_set, self.first_uv);
        Ok(Some(Picture { texture, uv_set, filter_encoded, premultiplied: d.premultiplied }))
    }
}

/// Where set `uv_set` of the file is when set `first` stands before all others.
pub(in super::super) fn place_of_set(uv_set: u32, first: u32) -> u32 {
    match uv_set {
        s if s == first => 0,
        s if s < first => s + 1,
        s => s,
    }
}

/// The set that all pictures of these nodes use; 0 when they use several. The likeness of a material knows one set.
pub(super) fn common_uv_set(nodes: &[Record]) -> Result<u32, ImportError> {
    let mut common = None;
    for node in nodes.iter().filter(|n| n.text("type").is_ok_and(|t| t == Some("image"))) {
        let set = match node.record("coordinates")? {
            Some(c) => c.count_or("uvSet", 0)?,
            None => 0,
        };
        if *common.get_or_insert(set) != set {
            return Ok(0);
        }
    }
    Ok(common.unwrap_or(0))
}

/// Cycles' colour of pictures that are not there.
const PINK: Vec3 = Vec3::new(1.0, 0.0, 1.0);

fn missing(channel: Channel) -> Option<Scalar> {
    let v = match channel {
        Channel::Red | Channel::Blue | Channel::Alpha => 1.0,
        Channel::Green => 0.0,
        Channel::Luminance => PINK.dot(LUMINANCE),
    };
    Some(v.into())
}

/// `k` times the number plus `d`.
fn line(s: Scalar, k: f32, d: f32) -> Scalar {
    Scalar { factor: s.factor * k, offset: s.offset * k + d, picture: s.picture }
}

/// The affine map of Blender's coordinates (v up) as one of the file's (v down).
fn uv_transform(affine: Option<[f64; 12]>) -> [[f32; 3]; 2] {
    let a = affine.unwrap_or([1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let u = [a[0], -a[1], a[1] + a[3]];
    let v = [-a[4], a[5], 1.0 - a[5] - a[7]];
    [u.map(|x| x as f32), v.map(|x| x as f32)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_set_comes_before_the_others_in_their_order() {
        assert_eq!([0, 1, 2, 3].map(|s| place_of_set(s, 0)), [0, 1, 2, 3]);
        assert_eq!([0, 1, 2, 3].map(|s| place_of_set(s, 2)), [1, 2, 0, 3]);
    }

    #[test]
    fn uv_transform_turns_v_over_on_both_sides() {
        let a = [2.0, 0.5, 0.0, 0.25, -1.0, 3.0, 0.0, 0.125, 0.0, 0.0, 1.0, 0.0];
        let t = uv_transform(Some(a));
        let (u, v) = (0.3f64, 0.8);
        let blender = [a[0] * u + a[1] * v + a[3], a[4] * u + a[5] * v + a[7]];
        let file = [u as f32, (1.0 - v) as f32, 1.0];
        let got = t.map(|row| row.iter().zip(file).map(|(m, x)| m * x).sum::<f32>());
        assert!((f64::from(got[0]) - blender[0]).abs() < 1e-6 && (f64::from(got[1]) - (1.0 - blender[1])).abs() < 1e-6, "{got:?}");
    }
}
