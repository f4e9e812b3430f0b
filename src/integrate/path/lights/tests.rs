//! Samplers of lamps, worlds and phase functions against their densities; lights by their chances.

use super::super::tests::{compiled, covered, lambert, lamp, scene};
use super::super::volume::{phase, sample_phase};
use super::LightSet;
use super::environment::ReadyEnvironment;
use super::lamp::ReadyLamp;
use crate::kernel::bsdf::tests::chi_square_score;
use crate::math::{DVec3, Transform, Vec3};
use crate::scene::environment::{EnvironmentSource, FloatImage, Sky};
use crate::scene::lamp::LampShape;
use crate::scene::{Environment, Lamp, Shape};
use std::f64::consts::PI;
use std::sync::Arc;

#[test]
fn lamps_draw_what_their_densities_say() {
    let above = Transform::translation(DVec3::new(0.2, -0.1, 0.9));
    let area = |ellipse, spread_rad| LampShape::Area { ellipse, size: [1.6, 0.9], spread_rad };
    for (name, shape) in [
        ("rectangle", area(false, PI)),
        ("ellipse", area(true, PI)),
        ("narrow rectangle", area(false, 1.5)),
        ("ball", LampShape::Point { radius: 0.5, soft_falloff: false }),
        ("facing disc", LampShape::Point { radius: 0.5, soft_falloff: true }),
        ("spot", LampShape::Spot { radius: 0.4, soft_falloff: false, angle_rad: 1.5, blend: 0.3 }),
        ("sun", LampShape::Sun { angle_rad: 1.2 }),
    ] {
        let ready = ReadyLamp::new(&Lamp::new(shape, Vec3::ONE, above)).expect("a lamp that shines");
        let score = chi_square_score(
            96,
            |rng| ready.sample(DVec3::ZERO, [rng.draw(), rng.draw()]).map(|s| s.dir.as_vec3()),
            |d| ready.hit(DVec3::ZERO, d.as_dvec3(), f64::INFINITY).map_or(0.0, |h| h.2),
        );
        assert!(score < 4.0, "{name}: score {score:.1}");
    }
}

#[test]
fn worlds_draw_what_their_densities_say() {
    let texels = (0..32 * 16).map(|k| Vec3::splat(0.1 + (k % 7) as f32 * 0.3 + f32::from(k == 200) * 10.0)).collect();
    let picture = EnvironmentSource::Equirect { image: Arc::new(FloatImage { width: 32, height: 16, texels }), linear: false };
    let sky = EnvironmentSource::Sky(Sky { sun_disc: false, ..Sky::default() });
    for (name, source) in [("picture", picture), ("sky", sky)] {
        let mut s = scene(vec![], vec![], Vec3::ONE);
        s.environment = Some(Environment { source, ..Environment::constant(Vec3::ONE) });
        let ready = ReadyEnvironment::new(&compiled(&s));
        assert!(ready.is_sampled());
        let score =
            chi_square_score(160, |rng| ready.sample(rng.draw(), rng.draw()).map(|s| s.0.as_vec3()), |d| ready.density(d.as_dvec3()));
        assert!(score < 4.0, "{name}: score {score:.1}");
    }
}

#[test]
fn phase_functions_draw_what_their_densities_say() {
    let dir = DVec3::new(0.3, -0.5, 0.8).normalize();
    for g in [-0.7f32, 0.0, 0.4, 0.85] {
        let score = chi_square_score(
            24,
            |rng| Some(sample_phase(g, dir, rng.draw(), rng.draw()).0.as_vec3()),
            |d| phase(g, d.as_dvec3().dot(dir) as f32),
        );
        assert!(score < 4.0, "g {g}: score {score:.1}");
    }
}

#[test]
fn lights_are_chosen_with_the_chances_that_are_told() {
    let lights = (0..40)
        .map(|k| {
            let at = DVec3::new(f64::from(k % 8) - 3.5, f64::from(k / 8) - 2.0, 1.0 + f64::from(k % 3));
            lamp(LampShape::Point { radius: 0.1, soft_falloff: false }, 5.0 + (k % 5) as f32 * 20.0, Transform::translation(at))
        })
        .collect();
    let s = scene(vec![covered(Shape::Plane { normal: DVec3::Z, distance: 0.0 }, lambert(0.5))], lights, Vec3::ZERO);
    let c = compiled(&s);
    let set = LightSet::new(&c, &[], None);
    let mut rng = crate::math::sobol::Pcg::new(3);
    for (p, n) in [(DVec3::ZERO, Some(DVec3::Z)), (DVec3::new(2.0, 1.0, 0.5), None)] {
        let draws = 40_000;
        let mut seen: Vec<(super::LightSource, f64, u32)> = Vec::new();
        for _ in 0..draws {
            let chosen = set.choose(&c, p, n, rng.draw()).expect("there are lights");
            match seen.iter_mut().find(|s| s.0 == chosen.source) {
                Some(s) => s.2 += 1,
                None => seen.push((chosen.source, f64::from(chosen.chance), 1)),
            }
        }
        // Pearson's statistic over those expected ten times or more.
        let (mut chi, mut cells) = (0.0, 0.0);
        for (_, chance, count) in seen.iter().filter(|s| s.1 * f64::from(draws) >= 10.0) {
            let expected = chance * f64::from(draws);
            chi += (f64::from(*count) - expected).powi(2) / expected;
            cells += 1.0;
        }
        let score = ((chi / cells).cbrt() - (1.0 - 2.0 / (9.0f64 * cells))) / (2.0 / (9.0f64 * cells)).sqrt();
        assert!(cells > 10.0 && score < 4.0, "{cells} lights, score {score:.1}");
    }
}
