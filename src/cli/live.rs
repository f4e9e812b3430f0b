//! `rayloom render --live FILE`: the picture so far, now and then, for programs that show it while it is made.

use rayloom::film::Film;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Writing takes at most one part of so many of the time.
const SHARE: u32 = 20;

/// Writes the picture so far. Told from any thread.
pub struct LivePicture {
    path: PathBuf,
    /// When the next one is due.
    due: Mutex<Instant>,
    /// Before the first picture and at least between two.
    pause: Duration,
}

impl LivePicture {
    /// Into `path`, from now on, each time that `pause` is over.
    pub fn new(path: &Path, pause: Duration) -> Self {
        Self { path: path.to_owned(), due: Mutex::new(Instant::now() + pause), pause }
    }

    /// Writes the finished film, due or not.
    pub fn finish(&self, film: &Film) -> bool {
        write(&self.path, &film.shown()).is_ok()
    }

    /// Writes `film` if it is time: `width * height` pixels of red, green, blue (times alpha), alpha, 32-bit floats with the lowest byte first,
    /// top row first; pixels without samples are 0. Beside, then renamed, so that a reader never meets a half. True when it was written.
    pub fn show(&self, film: &Film) -> bool {
        let Ok(mut due) = self.due.try_lock() else { return false };
        let start = Instant::now();
        if start < *due {
            return false;
        }
        // A disk that is full spoils the show, not the picture.
        let written = write(&self.path, film).is_ok();
        *due = Instant::now() + self.pause.max(start.elapsed() * SHARE);
        written
    }
}

fn write(path: &Path, film: &Film) -> std::io::Result<()> {
    let beside = path.with_added_extension("part");
    let mut bytes = Vec::with_capacity(16 * film.pixels.len());
    for ([r, g, b, transmit], n) in film.pixels.iter().zip(&film.samples) {
        let pixel = if *n > 0 { [*r, *g, *b, 1.0 - transmit] } else { [0.0; 4] };
        bytes.extend(pixel.iter().flat_map(|v| v.to_le_bytes()));
    }
    std::fs::File::create(&beside)?.write_all(&bytes)?;
    std::fs::rename(&beside, path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_live_picture_holds_what_is_there_and_comes_when_due() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("live");
        let live = LivePicture::new(&path, Duration::from_secs(9));
        let mut film = Film::new(2, 1);
        assert!(!live.show(&film) && !path.exists());
        (film.pixels[1], film.samples[1]) = ([0.5, 0.25, 2.0, 0.25], 3);
        *live.due.lock().expect("alone") = Instant::now();
        assert!(live.show(&film) && !live.show(&film));
        let floats: Vec<f32> =
            std::fs::read(&path).expect("it is there").chunks_exact(4).map(|c| f32::from_le_bytes(c.try_into().expect("four"))).collect();
        assert_eq!(floats, [0.0, 0.0, 0.0, 0.0, 0.5, 0.25, 2.0, 0.75]);
    }
}
