//! With the library where it is found (`RAYLOOM_OIDN` names it; `RAYLOOM_REQUIRE_OIDN=1` makes its absence a failure), and without it.

use super::*;
use crate::film::Film;
use crate::math::sobol::Pcg;

/// The library, or nothing on machines without it.
fn library() -> Option<Denoiser> {
    match Denoiser::load(None) {
        Ok(d) => Some(d),
        Err(e) => {
            assert!(std::env::var_os("RAYLOOM_REQUIRE_OIDN").is_none(), "{e}");
            eprintln!("not tested: {e}");
            None
        }
    }
}

/// A noisy step from 0.2 to 2 in the middle, with clean guides.
fn noisy(width: u32, height: u32) -> (Film, Vec<f32>) {
    let mut film = Film::with_passes(width, height, guide_passes(&DenoiseSettings::default()));
    let mut rng = Pcg::new(7);
    let mut truth = Vec::new();
    for at in 0..film.pixels.len() {
        let value = if (at as u32 % width) < width / 2 { 0.2 } else { 2.0 };
        // Exponential: its mean is 1.
        film.pixels[at] = [0, 1, 2, 3].map(|c| if c < 3 { value * -(1.0f32 - rng.draw()).max(1e-6).ln() } else { 0.25 });
        film.samples[at] = 1;
        film.layers[0].values[3 * at..3 * at + 3].fill(value / 2.0);
        film.layers[1].values[3 * at..3 * at + 3].copy_from_slice(&[0.0, 0.0, -1.0]);
        truth.push(value);
    }
    (film, truth)
}

#[test]
fn noise_goes_edges_stay_and_the_noisy_colours_are_kept() {
    let Some(denoiser) = library() else { return };
    let (film, truth) = noisy(96, 64);
    let error = |f: &Film| -> f32 {
        let sum: f32 = f.pixels.iter().zip(&truth).map(|(p, t)| ((p[0] - t) / t).powi(2)).sum();
        (sum / truth.len() as f32).sqrt()
    };
    let never = AtomicBool::new(false);
    for prefilter in [Prefilter::None, Prefilter::Fast, Prefilter::Accurate] {
        let mut clean = film.clone();
        let shares = std::sync::Mutex::new(Vec::new());
        let settings = DenoiseSettings { prefilter, ..DenoiseSettings::default() };
        let told = |share| shares.lock().expect("no panic").push(share);
        denoiser.film(&mut clean, [0, 0, 96, 64], &settings, 2, &told, &never).expect("denoises");
        assert_eq!(clean.pixels, film.pixels);
        let (before, after) = (error(&film), error(&clean.shown()));
        assert!(before > 0.9 && after < 0.25, "{prefilter:?}: {before} before, {after} after");
        assert!(clean.shown().pixels.iter().all(|p| p[3] == 0.25), "alpha is left alone");
        let shares = shares.into_inner().expect("no panic");
        assert!(shares.iter().all(|s| (0.0..=1.0).contains(s)) && shares.is_sorted(), "{shares:?}");
    }
}

#[test]
fn a_part_is_denoised_alone_and_a_cancel_ends_it() {
    let Some(denoiser) = library() else { return };
    let (film, _) = noisy(64, 64);
    let settings = DenoiseSettings { guides: Guides::None, ..DenoiseSettings::default() };
    let mut clean = film.clone();
    denoiser.film(&mut clean, [8, 16, 40, 48], &settings, 1, &|_| {}, &AtomicBool::new(false)).expect("denoises");
    let shown = clean.shown();
    for (at, (a, b)) in shown.pixels.iter().zip(&film.pixels).enumerate() {
        let (x, y) = (at % 64, at / 64);
        let inside = (8..40).contains(&x) && (16..48).contains(&y);
        assert_eq!(a == b, !inside, "({x}, {y})");
    }
    let stopped = denoiser.film(&mut clean, [0, 0, 64, 64], &settings, 1, &|_| {}, &AtomicBool::new(true));
    assert!(matches!(stopped, Err(DenoiseError::Interrupted)), "{stopped:?}");
}

#[test]
fn what_is_no_such_library_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("libOpenImageDenoise.so.2");
    std::fs::write(&file, b"no library").expect("writable");
    let Err(wrong) = Denoiser::load(Some(&file)) else { panic!("it loaded") };
    assert!(wrong.to_string().contains("cannot be used"), "{wrong}");
    let Err(missing) = Denoiser::load(Some(&folder.path().join("none"))) else { panic!("it loaded") };
    assert!(missing.to_string().contains("--denoise-library"), "{missing}");
}
