//! Skies against what Cycles shows (`tests/measured/cycles_sky.py`).

use super::*;

fn model(word: &str) -> SkyModel {
    match word {
        "nishita" => SkyModel::Nishita,
        "single" => SkyModel::Single,
        "multiple" => SkyModel::Multiple,
        other => panic!("a sky of {other}"),
    }
}

/// Lines of the measurements that begin with `word`: their words and their numbers.
fn measured(word: &str) -> impl Iterator<Item = (&'static str, Vec<&'static str>)> {
    let lines = include_str!("../../../../../tests/measured/cycles_sky.txt").lines();
    let word = format!("{word} ");
    lines.filter(move |l| l.starts_with(&word)).map(|l| (l, l.split(' ').skip(1).collect()))
}

fn numbers(words: &[&str]) -> Vec<f32> {
    words.iter().map(|w| w.parse().expect("a number")).collect()
}

/// Differences of the skies of a model from Cycles, over the largest channel.
fn differences(word: &str) -> Vec<(f32, String)> {
    let mut made: Option<(Sky, ReadySky)> = None;
    let mut out = Vec::new();
    for (line, words) in measured(word) {
        let v = numbers(&words);
        let sky = Sky {
            model: model(word),
            sun_disc: false,
            sun_elevation_rad: v[0].to_radians(),
            sun_rotation_rad: v[1].to_radians(),
            air_density: v[2],
            dust_density: v[3],
            ozone_density: v[4],
            altitude_m: v[5],
            ..Sky::default()
        };
        if made.as_ref().is_none_or(|m| m.0 != sky) {
            made = Some((sky.clone(), ReadySky::new(&sky)));
        }
        let Some((_, ready)) = &made else { continue };
        let (e, a) = (v[6].to_radians(), v[7].to_radians());
        let got = ready.radiance(Vec3::new(e.cos() * a.cos(), e.cos() * a.sin(), e.sin()).as_dvec3());
        let want = Vec3::new(v[8], v[9], v[10]);
        // The metre down to the ground, from its height 0, is rounding in Cycles' 32 bits.
        let rounding = if sky.model == SkyModel::Multiple && v[5] == 0.0 && v[6] < 0.0 { 15.0 } else { 1.0 };
        let off = ((got - want) / want.max_element().max(1e-5)).abs().max_element() / rounding;
        out.push((off, format!("{line}: {got}, off by {off:.4}")));
    }
    assert!(out.len() > 100, "{word}: {} lines", out.len());
    out
}

fn hold(word: &str, limit: f32, typical: f32) {
    let mut all = differences(word);
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let wrong: Vec<_> = all.iter().filter(|d| d.0 > limit).map(|d| d.1.as_str()).collect();
    assert!(wrong.is_empty(), "{} differ\n{}", wrong.len(), wrong.join("\n"));
    let middle = all[all.len() / 2].0;
    assert!(middle < typical, "{word}: {middle} in the middle");
}

#[test]
fn skies_of_blender_4_are_as_bright_as_cycles_measures_them() {
    hold("nishita", 5e-3, 1e-3);
}

#[test]
fn skies_of_light_scattered_once_are_as_bright_as_cycles_measures_them() {
    hold("single", 5e-3, 1e-3);
}

#[test]
fn skies_of_light_scattered_many_times_are_as_bright_as_cycles_measures_them() {
    hold("multiple", 1e-2, 1e-3);
}

#[test]
fn discs_are_as_bright_as_cycles_measures_them() {
    let (mut n, mut wrong) = (0, Vec::new());
    for (line, words) in measured("disc") {
        let v = numbers(&words[1..]);
        let size = v[1].to_radians();
        let sky =
            Sky { model: model(words[0]), sun_elevation_rad: v[0].to_radians(), sun_size_rad: size, altitude_m: 100.0, ..Sky::default() };
        let up = f64::from(v[2]).to_radians();
        let (sin, cos) = (f64::from(v[0]).to_radians() + up).sin_cos();
        let dir = DVec3::new(0.0, cos, sin);
        let got = ReadySky::disc_of(&sky).map_or(Vec3::ZERO, |d| d.toward(dir));
        let want = Vec3::new(v[3], v[4], v[5]).max(Vec3::ZERO);
        let off = ((got - want) / want.max_element().max(1.0)).abs().max_element();
        // The reddest light of a disc on the horizon is off by 2 %.
        let limit = if words[0] != "multiple" && v[0] < 5.0 { 2e-2 } else { 1e-2 };
        if off > limit {
            wrong.push(format!("{line}: {got}, off by {off:.4}"));
        }
        n += 1;
    }
    assert!(wrong.is_empty(), "{} differ\n{}", wrong.len(), wrong.join("\n"));
    assert!(n >= 90, "{n} lines");
}

#[test]
fn sun_is_bright_white_above_and_red_at_the_horizon() {
    for model in [SkyModel::Nishita, SkyModel::Single, SkyModel::Multiple] {
        let disc = |e: f32| ReadySky::disc_of(&Sky { model, sun_elevation_rad: e, ..Sky::default() }).expect("a disc").mean();
        let (noon, dusk) = (disc(1.2), disc(0.02));
        assert!(noon.x / noon.z < 1.6 && dusk.x / dusk.z > 5.0, "{noon} {dusk}");
        assert!(ReadySky::disc_of(&Sky { model, sun_elevation_rad: -0.1, ..Sky::default() }).is_none());
    }
}

#[test]
fn the_ground_is_dark_under_light_scattered_once_and_veiled_under_more() {
    let at_nadir = |model| ReadySky::new(&Sky { model, altitude_m: 100.0, ..Sky::default() }).radiance(DVec3::NEG_Z);
    assert_eq!(at_nadir(SkyModel::Nishita), Vec3::ZERO);
    assert_eq!(at_nadir(SkyModel::Single), Vec3::ZERO);
    assert!(at_nadir(SkyModel::Multiple).min_element() > 0.0);
}

impl ReadySky {
    /// The disc alone, without the work for the sky.
    fn disc_of(sky: &Sky) -> Option<Disc> {
        let elevation = f64::from(sky.sun_elevation_rad);
        let dir = DVec3::new(0.0, elevation.cos(), elevation.sin());
        match sky.model {
            SkyModel::Multiple => disc(sky, &multiple::Air::new(sky), elevation, dir),
            SkyModel::Nishita | SkyModel::Single => disc(sky, &single::Air::new(sky), elevation, dir),
        }
    }
}
