//! Lamps, the tree over lights, the environment as words. Twins: `shaders/path/lamp.wesl`, `light_tree.wesl`, `lights.wesl`, `environment.wesl`.

use super::super::buffers::{append, bits, v3};
use super::super::layout::PathParams;
use super::inputs::Encoder;
use crate::integrate::path::PathPlan;
use crate::integrate::path::lights::emitter::Emitter;
use crate::integrate::path::lights::environment::Kind;
use crate::integrate::path::lights::grey;
use crate::integrate::path::lights::lamp::ReadyLamp;
use crate::integrate::path::lights::sky::{COLUMNS, ROWS};
use crate::integrate::path::lights::tree::LightTree;
use crate::math::DVec3;
use crate::scene::Visibility;
use crate::scene::lamp::LampShape;
use std::f64::consts::PI;

/// Words of a lamp: name and length.
const LAMP: &[(&str, u32)] = &[
    ("KIND", 1),
    ("FLAGS", 1),
    ("MAX_BOUNCES", 1),
    ("RADIUS", 1),
    ("CENTER", 3),
    ("AREA", 1),
    ("AXIS", 3),
    ("COS_HALF", 1),
    ("HALF0", 3),
    ("SOFT", 1),
    ("HALF1", 3),
    ("TAN_SPREAD", 1),
    ("RADIANCE", 3),
    ("LEAF", 1),
    ("OPEN", 1),
    ("ENERGY", 1),
    // Rows of the map into the lamp's own space.
    ("INVERSE", 9),
];
/// Words of a shining face: its place among the faces, that of the other half of a rectangle, place of the rectangle's words ([`LAMP`]) or 0.
const EMITTER: &[(&str, u32)] = &[("FACE", 1), ("SECOND", 1), ("RECTANGLE", 1)];
/// Bits beside those of visibility.
const NO_SHADOW: u32 = 1 << 8;
const NEVER_MET: u32 = 1 << 9;
const ELLIPSE: u32 = 1 << 10;
const FACES_POINT: u32 = 1 << 11;
const BY_CHANCE: u32 = 1 << 12;
const IS_POINT: u32 = 0;
const IS_SPOT: u32 = 1;
const IS_SUN: u32 = 2;
const IS_AREA: u32 = 3;

/// Names and numbers for the shaders.
pub(super) fn light_constants() -> Vec<(String, u32)> {
    let places = [("LAMP", LAMP), ("EMITTER", EMITTER)].into_iter().flat_map(|(record, words)| {
        let mut at = 0;
        let mut place = |len: &u32| {
            at += len;
            at - len
        };
        let mut places: Vec<(String, u32)> = words.iter().map(|(name, len)| (format!("{record}_{name}"), place(len))).collect();
        places.push((format!("{record}_WORDS"), at));
        places
    });
    let others = [
        ("LAMP_NEVER_MET", NEVER_MET),
        ("LAMP_ELLIPSE", ELLIPSE),
        ("LAMP_FACES_POINT", FACES_POINT),
        ("LAMP_BY_CHANCE", BY_CHANCE),
        ("LAMP_IS_SPOT", IS_SPOT),
        ("LAMP_IS_SUN", IS_SUN),
        ("LAMP_IS_AREA", IS_AREA),
        ("SKY_COLUMNS", COLUMNS as u32),
        ("SKY_ROWS", ROWS as u32),
    ];
    places.chain(others.map(|(n, v)| (n.to_owned(), v))).collect()
}

/// Encodes all lights but shining faces, which stand among the faces.
pub(super) fn encode_lights(plan: &PathPlan, e: &mut Encoder, p: &mut PathParams) {
    let l = &plan.lights;
    let lamps: Vec<u32> = l.lamps.iter().enumerate().flat_map(|(k, lamp)| lamp_words(lamp, leaf_of(plan, k), e)).collect();
    let n_words = LAMP.iter().map(|f| f.1).sum::<u32>();
    p.n_lamps = l.lamps.len() as u32;
    p.lamps_at = append(&mut e.words, lamps);
    let place = |k: &u32| p.lamps_at + k * n_words;
    p.n_suns = l.suns.len() as u32;
    let suns: Vec<u32> = l.suns.iter().map(place).collect();
    let tree_lamps: Vec<u32> = l.tree_lamps.iter().map(place).collect();
    p.n_tree_lamps = tree_lamps.len() as u32;
    p.suns_at = append(&mut e.words, suns);
    p.tree_lamps_at = append(&mut e.words, tree_lamps);
    p.leaves_at = append(&mut e.words, l.tree.leaves().iter().copied());
    let mut need = |feature: &'static str, holds: bool| {
        if holds {
            e.features.insert(feature);
        }
    };
    need("light_tree", !l.tree.is_empty());
    need("emitters", !l.emitters.list.is_empty());
    need("tree_lamps", !l.tree_lamps.is_empty());
    need("lamps", !l.lamps.is_empty());
    need("suns", !l.suns.is_empty());
    need("met_lamps", l.lamps.iter().any(|l| l.lamp.multiple_importance && has_size(l)));
    need("shadowless", l.lamps.iter().any(|l| !l.lamp.cast_shadow));
    let lit = Visibility::DIFFUSE.with(Visibility::GLOSSY).with(Visibility::TRANSMISSION);
    need("light_visibility", l.lamps.iter().any(|l| !l.lamp.visibility.has(lit)));
    need("any_light", !l.is_empty());
    let env = &l.environment;
    need("env_sampled", env.sampling.is_some());
    need("sky_sun", l.sky_sun.is_some());
    // Each sun is drawn by its own share.
    let kinds = [!l.tree.is_empty(), env.sampling.is_some(), l.sky_sun.is_some(), !l.suns.is_empty()];
    need("many_kinds", kinds.iter().filter(|k| **k).count() > 1 || !l.suns.is_empty() || l.sky_sun.is_some());
    need("environment", env.strength.max_element() > 0.0 && env.visibility.0 & 31 != 0);
    encode_environment(plan, e, p);
}

/// Shining faces, of the places among the faces that stand in `places`; gives where they begin.
pub(super) fn encode_emitters(list: &[Emitter], places: &[[u32; 2]], e: &mut Encoder) -> u32 {
    let words: Vec<u32> = list
        .iter()
        .zip(places)
        .flat_map(|(emitter, [first, second])| {
            let Some(r) = &emitter.rectangle else { return [*first, *first, 0] };
            e.features.insert("rectangles");
            // What a lamp needs to be seen as a rectangle; the rest is the faces'.
            let mut w = vec![0; LAMP.iter().map(|f| f.1).sum::<u32>() as usize];
            let numbers = [
                ("CENTER", v3(r.center).to_vec()),
                ("AREA", vec![r.area as f32]),
                ("HALF0", v3(r.half[0]).to_vec()),
                ("HALF1", v3(r.half[1]).to_vec()),
            ];
            for (name, values) in numbers {
                let at: u32 = LAMP.iter().take_while(|f| f.0 != name).map(|f| f.1).sum();
                values.into_iter().zip(at as usize..).for_each(|(v, k)| w[k] = v.to_bits());
            }
            [*first, *second, append(&mut e.words, w)]
        })
        .collect();
    append(&mut e.words, words)
}

fn leaf_of(plan: &PathPlan, k: usize) -> u32 {
    match plan.lights.tree_of_lamp[k] {
        u32::MAX => u32::MAX,
        at => plan.lights.tree.leaves()[at as usize],
    }
}

fn has_size(l: &ReadyLamp) -> bool {
    match l.lamp.shape {
        LampShape::Area { .. } => true,
        LampShape::Sun { .. } => l.cos_half < 1.0,
        _ => l.radius() > 0.0,
    }
}

fn lamp_words(l: &ReadyLamp, leaf: u32, e: &mut Encoder) -> Vec<u32> {
    let n = |v: f64| (v as f32).to_bits();
    let flag = |holds: bool, bit: u32| if holds { bit } else { 0 };
    let (mut kind, mut flags) = (IS_POINT, 0);
    match l.lamp.shape {
        LampShape::Point { soft_falloff, .. } => flags |= flag(soft_falloff, FACES_POINT),
        LampShape::Spot { soft_falloff, .. } => {
            kind = IS_SPOT;
            flags |= flag(soft_falloff, FACES_POINT);
        }
        LampShape::Sun { .. } => kind = IS_SUN,
        LampShape::Area { ellipse, .. } => {
            kind = IS_AREA;
            flags |= flag(ellipse, ELLIPSE);
        }
    }
    e.features.insert(if kind == IS_AREA { "areas" } else { "balls" });
    flags |= u32::from(l.lamp.visibility.0);
    flags |= flag(!l.lamp.cast_shadow, NO_SHADOW) | flag(!l.lamp.multiple_importance, NEVER_MET);
    flags |= flag(l.lamp.multiple_importance && has_size(l), BY_CHANCE);
    let mut w = vec![kind, flags, l.lamp.max_bounces, n(l.radius())];
    w.extend(bits(v3(l.center)));
    w.push(n(l.area));
    w.extend(bits(v3(l.axis)));
    w.push(n(l.cos_half));
    w.extend(bits(v3(l.half[0])));
    w.push(n(l.soft));
    w.extend(bits(v3(l.half[1])));
    w.push(n(l.half_spread.tan()));
    w.extend(bits(l.radiance.to_array()));
    w.extend([leaf, n(1.0 - l.cos_half), n(grey(l.intensity()))]);
    let m = l.lamp.transform.inverse.matrix3;
    w.extend((0..3).flat_map(|k| [n(m.x_axis[k]), n(m.y_axis[k]), n(m.z_axis[k])]));
    debug_assert_eq!(w.len() as u32, LAMP.iter().map(|f| f.1).sum::<u32>(), "as the shader reads it");
    w
}

/// Nodes of the tree, four vectors each.
pub(super) fn tree_quads(tree: &LightTree) -> impl Iterator<Item = [u32; 4]> + '_ {
    tree.nodes().iter().flat_map(|n| {
        let f = |v: f64| (v as f32).to_bits();
        let v = |v: DVec3| v3(v).map(f32::to_bits);
        let ([x, y, z], [ax, ay, az]) = (v(n.center), v(n.axis));
        [
            [x, y, z, f(n.radius)],
            [ax, ay, az, f(n.cos_spread)],
            [f(n.sin_spread), f(n.cos_reach), f(n.energy), n.right],
            [n.parent, n.light, 0, 0],
        ]
    })
}

fn encode_environment(plan: &PathPlan, e: &mut Encoder, p: &mut PathParams) {
    let env = &plan.lights.environment;
    p.env_visibility = u32::from(env.visibility.0);
    p.env_strength = env.strength.to_array();
    let r = env.rotation;
    [p.env_x, p.env_y, p.env_z] = [v3(r.x_axis), v3(r.y_axis), v3(r.z_axis)];
    p.env_estimate = env.estimate() as f32;
    let picture = |image: &crate::scene::environment::FloatImage, linear: bool, e: &mut Encoder| {
        let head = [image.width, image.height, u32::from(linear)];
        let texels = image.texels.iter().flat_map(|c| c.to_array()).map(f32::to_bits);
        append(&mut e.words, head.into_iter().chain(texels))
    };
    match &env.kind {
        Kind::Constant | Kind::Pov => {}
        Kind::Equirect { image, linear } => {
            e.features.insert("env_picture");
            p.env_at = picture(image, *linear, e);
        }
        Kind::MirrorBall { image, linear } => {
            e.features.extend(["env_picture", "mirror_ball"]);
            p.env_at = picture(image, *linear, e);
        }
        Kind::Sky(sky) => {
            e.features.insert("sky");
            if sky.below {
                e.features.insert("sky_below");
            }
            p.sky_sun = v3(sky.sun);
            p.env_at = append(&mut e.words, sky.table.iter().flat_map(|c| c.to_array()).map(f32::to_bits));
        }
    }
    if let Some(s) = &env.sampling {
        let sums = s.rows.iter().chain(&s.column).map(|v| v.to_bits());
        p.env_sums_at = append(&mut e.words, [s.width as u32, s.height as u32].into_iter().chain(sums));
    }
    if let Some(s) = &plan.lights.sky_sun {
        let open = 1.0 - s.cos_half;
        let [foot, top] = s.disc.radiance.map(|c| c.to_array());
        p.sky_sun_dir = v3(s.disc.dir);
        p.sky_sun_open = open as f32;
        p.sky_sun_half = s.disc.half as f32;
        p.sky_sun_up = v3(s.disc.up);
        p.sky_sun_foot = foot;
        p.sky_sun_foot_height = s.disc.heights[0] as f32;
        p.sky_sun_top = top;
        p.sky_sun_span = (s.disc.heights[1] - s.disc.heights[0]) as f32;
        p.sky_sun_energy = (grey(s.disc.mean()) * 2.0 * PI * open) as f32;
    }
}
