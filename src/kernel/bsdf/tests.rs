//! Every lobe: a white room stays white, and samplers draw what the densities say.

use super::diffuse::OrenNayar;
use super::frame::{Frame, uniform_sphere};
use super::fresnel::Fresnel;
use super::ggx::Ggx;
use super::hair::{Hair, HairParams};
use super::microfacet::Microfacet;
use super::sheen::Sheen;
use super::{Lobe, LobeKind, albedo};
use crate::math::Vec3;
use crate::math::sobol::{Pcg, sobol4};

const ROUGHNESSES: [f32; 7] = [0.0, 0.05, 0.1, 0.25, 0.5, 0.75, 1.0];
const COSINES: [f32; 4] = [0.1, 0.4, 0.8, 1.0];

fn viewer(cos: f32) -> Vec3 {
    Vec3::new((1.0 - cos * cos).sqrt() * 0.8, (1.0 - cos * cos).sqrt() * 0.6, cos)
}

fn lobe(kind: LobeKind) -> Lobe {
    Lobe { weight: Vec3::ONE, chance: 1.0, frame: Frame { t: Vec3::X, b: Vec3::Y, n: Vec3::Z }, kind, is_bent: false }
}

fn facets(roughness: f32, fresnel: Fresnel, refracts: bool) -> LobeKind {
    LobeKind::Microfacet(Microfacet { ggx: Ggx::isotropic(roughness * roughness), fresnel, refracts })
}

/// Mean of value / density: what the lobe gives back of white light from everywhere.
fn furnace(l: &Lobe, v: Vec3) -> f32 {
    let n = 1 << 15;
    let mut sum = 0.0f64;
    for k in 0..n {
        let u = sobol4(3, k, 0);
        if let Some(s) = l.sample(v, [u[0], u[1], u[2]]) {
            sum += f64::from(s.value.x / s.pdf);
        }
    }
    (sum / f64::from(n)) as f32
}

#[test]
fn white_lobes_are_white_in_a_white_room() {
    for cos in COSINES {
        let v = viewer(cos);
        let near_one = |name: &str, got: f32| assert!((got - 1.0).abs() < 1e-3, "{name} at cosine {cos}: {got}");
        near_one("lambert", furnace(&lobe(LobeKind::Lambert), v));
        near_one("translucent", furnace(&lobe(LobeKind::Translucent), v));
        for r in ROUGHNESSES {
            near_one(&format!("oren-nayar {r}"), furnace(&lobe(LobeKind::OrenNayar(OrenNayar::new(r, Vec3::ONE, cos))), v));
            let e = albedo::mirror(r, cos);
            near_one(&format!("mirror {r}"), furnace(&lobe(facets(r, Fresnel::Mirror, false)), v) / e);
            for eta in [1.5f32, 1.0 / 1.5, 1.1, 2.4] {
                let fresnel = Fresnel::Dielectric { eta, f0: Vec3::splat(super::fresnel::f0_of(eta)), tint: [Vec3::ONE; 2] };
                let e = albedo::glass(eta, r, cos);
                near_one(&format!("glass {r} {eta}"), furnace(&lobe(facets(r, fresnel, true)), v) / e);
            }
        }
    }
}

#[test]
fn clear_hair_is_white_in_a_white_room() {
    for roughness in [0.1, 0.3, 0.6, 0.9] {
        for h in [-0.8, 0.0, 0.5] {
            let p = HairParams { sigma: Vec3::ZERO, roughness, radial_roughness: 0.4, coat: 0.0, ior: 1.55, offset_rad: 0.0 };
            let v = Vec3::new(0.3, 0.5, 0.812_404).normalize();
            let got = furnace(&lobe(LobeKind::Hair(Hair::new(&p, h, v))), v);
            assert!((got - 1.0).abs() < 1e-3, "roughness {roughness}, h {h}: {got}");
        }
    }
}

/// How unlikely a sampler's draws are under its density, as a normal score (4: 1 in 30,000 fails by chance): Pearson's statistic over 20 x 40
/// cells of the sphere, with one more cell for what is lost. `sub` squared points of each cell give what is expected there.
pub(crate) fn chi_square_score(sub: usize, mut draw: impl FnMut(&mut Pcg) -> Option<Vec3>, density: impl Fn(Vec3) -> f32) -> f64 {
    const ROWS: usize = 20;
    const COLUMNS: usize = 40;
    let n = 1 << 17;
    let mut counts = vec![0.0f64; ROWS * COLUMNS + 1];
    let mut rng = Pcg::new(5);
    for _ in 0..n {
        let cell = draw(&mut rng).map_or(ROWS * COLUMNS, |l| {
            let row = (((1.0 - l.z) / 2.0 * ROWS as f32) as usize).min(ROWS - 1);
            let turn = l.y.atan2(l.x) / std::f32::consts::TAU + 0.5;
            row * COLUMNS + ((turn * COLUMNS as f32) as usize).min(COLUMNS - 1)
        });
        counts[cell] += 1.0;
    }
    let mut expected = vec![0.0f64; ROWS * COLUMNS + 1];
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let mut sum = 0.0f64;
            for k in 0..sub * sub {
                let u = (row as f32 + ((k / sub) as f32 + 0.5) / sub as f32) / ROWS as f32;
                let w = (column as f32 + ((k % sub) as f32 + 0.5) / sub as f32) / COLUMNS as f32;
                sum += f64::from(density(uniform_sphere(u, w - 0.5)));
            }
            let area = 4.0 * std::f64::consts::PI / (ROWS * COLUMNS) as f64;
            expected[row * COLUMNS + column] = sum / (sub * sub) as f64 * area * f64::from(n);
        }
    }
    let total: f64 = expected.iter().sum();
    expected[ROWS * COLUMNS] = f64::from(n) - total;
    // Cells with few expected are pooled.
    let (mut chi, mut cells, mut pool) = (0.0, 0.0f64, (0.0, 0.0));
    for (c, e) in counts.iter().zip(&expected) {
        if *e < 10.0 {
            pool = (pool.0 + c, pool.1 + e.max(0.0));
        } else {
            chi += (c - e) * (c - e) / e;
            cells += 1.0;
        }
    }
    if pool.1 > 5.0 {
        chi += (pool.0 - pool.1) * (pool.0 - pool.1) / pool.1;
        cells += 1.0;
    }
    // Wilson and Hilferty's normal score.
    let freedom = cells - 1.0;
    ((chi / freedom).cbrt() - (1.0 - 2.0 / (9.0 * freedom))) / (2.0 / (9.0 * freedom)).sqrt()
}

#[test]
fn samplers_draw_what_their_densities_say() {
    let p = HairParams { sigma: Vec3::splat(0.3), roughness: 0.4, radial_roughness: 0.5, coat: 0.0, ior: 1.55, offset_rad: 0.03 };
    for cos in [0.25, 0.9] {
        let v = viewer(cos);
        let glass = |eta: f32| Fresnel::Dielectric { eta, f0: Vec3::splat(super::fresnel::f0_of(eta)), tint: [Vec3::ONE; 2] };
        let aniso = LobeKind::Microfacet(Microfacet { ggx: Ggx { ax: 0.6, ay: 0.15 }, fresnel: Fresnel::Mirror, refracts: false });
        let kinds = [
            ("lambert", LobeKind::Lambert),
            ("oren-nayar", LobeKind::OrenNayar(OrenNayar::new(0.7, Vec3::splat(0.5), cos))),
            ("translucent", LobeKind::Translucent),
            ("ggx 0.5", facets(0.5, Fresnel::Mirror, false)),
            ("ggx 1", facets(1.0, Fresnel::Mirror, false)),
            ("anisotropic", aniso),
            ("glass in", facets(0.6, glass(1.5), true)),
            ("glass out", facets(0.6, glass(1.0 / 1.5), true)),
            ("sheen 0.3", LobeKind::Sheen(Sheen::new(0.3, v))),
            ("sheen 0.9", LobeKind::Sheen(Sheen::new(0.9, v))),
            ("hair", LobeKind::Hair(Hair::new(&p, 0.4, v))),
        ];
        for (name, kind) in kinds {
            let l = lobe(kind);
            // Refraction answers lamps in directions that are never drawn, too.
            let is_drawn = |d: Vec3| !matches!(&l.kind, LobeKind::Microfacet(m) if m.refracts && !m.is_drawn(v, d));
            let density = |d: Vec3| if is_drawn(d) { l.eval(v, d).1 } else { 0.0 };
            let score = chi_square_score(24, |rng| Some(l.sample(v, [rng.draw(), rng.draw(), rng.draw()])?.l), density);
            assert!(score < 4.0, "{name} at cosine {cos}: score {score:.1}");
        }
    }
}

/// Source: suns behind a Refraction BSDF in Cycles 4.5 (`tests/measured/cycles_refraction.py`).
#[test]
fn rough_refraction_towards_lamps_is_what_cycles_measures() {
    let mut n = 0;
    for line in include_str!("../../../tests/measured/cycles_refraction.txt").lines().filter(|l| !l.starts_with('#')) {
        let words: Vec<f32> = line.split(' ').map(|w| w.parse().expect("a number")).collect();
        let [roughness, eta, view, light, want] = words[..] else { panic!("five numbers: {line}") };
        let toward = |degrees: f32, side: f32| Vec3::new(side * degrees.to_radians().sin(), 0.0, side * degrees.to_radians().cos());
        let got = lobe(facets(roughness, Fresnel::Clear { eta }, true)).eval(toward(view, 1.0), toward(light, -1.0)).0.x;
        assert!((got / want - 1.0).abs() < 1e-3, "{line}: {got}");
        n += 1;
    }
    assert_eq!(n, 72);
}

#[test]
fn the_chi_square_test_finds_a_wrong_density() {
    let l = lobe(LobeKind::Lambert);
    let v = viewer(0.5);
    let score =
        chi_square_score(24, |rng| Some(l.sample(v, [rng.draw(), rng.draw(), rng.draw()])?.l), |d| l.eval(v, d).1 * (1.0 + 0.15 * d.x));
    assert!(score > 8.0, "score {score}");
}

/// A lobe whose normal leans away from the flat face.
#[test]
fn sets_of_lobes_with_bent_normals_draw_what_their_densities_say() {
    let bent = Vec3::new(0.5, 0.2, 0.8).normalize();
    for (name, kind) in
        [("ggx 0.9", facets(0.9, Fresnel::Mirror, false)), ("ggx 0.4", facets(0.4, Fresnel::Mirror, false)), ("lambert", LobeKind::Lambert)]
    {
        let mut set = super::LobeSet::new(Vec3::Z, Vec3::Z);
        set.push(Lobe { frame: Frame::about(bent), is_bent: true, ..lobe(kind) });
        set.push(Lobe { chance: 0.5, ..lobe(LobeKind::Lambert) });
        let v = viewer(0.7);
        // Nothing is drawn below the flat face, where matt lobes still answer lamps that ask.
        let density = |d: Vec3| if d.z > 0.0 { set.eval(v, d).1 } else { 0.0 };
        let score = chi_square_score(32, |rng| Some(set.sample(v, [rng.draw(), rng.draw(), rng.draw(), rng.draw()])?.l), density);
        assert!(score < 4.0, "{name}: score {score:.1}");
    }
}

/// Frames are orthonormal and right-handed all around the sphere, and an upright wall's is the same whichever sign rounding gave the z of its normal.
#[test]
fn frames_do_not_turn_with_rounding() {
    for i in 0..1000 {
        let n = uniform_sphere((i as f32 + 0.5) / 1000.0, (i as f32 * 0.618_034).fract());
        let f = Frame::about(n);
        for (a, b) in [(f.t.cross(f.b), n), (f.b.cross(n), f.t), (n.cross(f.t), f.b)] {
            assert!((a - b).length() < 1e-5, "{n:?} has {f:?}");
        }
        let wall = Vec3::new(n.x, n.y, 0.0).normalize();
        let (above, below) = (Frame::about(wall + Vec3::Z * 1e-9), Frame::about(wall - Vec3::Z * 1e-9));
        assert!((above.t - below.t).length() < 1e-6, "{wall:?} has {above:?} and {below:?}");
    }
}
