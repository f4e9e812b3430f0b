//! Ctrl-C, SIGTERM and the end of a parent: the first asks the renderer to stop and save, the next ends the program at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What a signal finds.
#[derive(Clone, Debug)]
pub struct Interrupt {
    /// Set by the first signal.
    pub cancel: Arc<AtomicBool>,
    /// Whether rays are traced: before that there is nothing to save, and the first signal ends the program.
    pub rendering: Arc<AtomicBool>,
}

impl Interrupt {
    /// Listens to signals; `exit_code` is for those that end the program at once.
    pub fn listen(exit_code: u8) -> Self {
        let own = Self { cancel: Arc::default(), rendering: Arc::default() };
        let seen = own.clone();
        // Without a handler the signal ends the program, which is no worse than before.
        let _ = ctrlc::set_handler(move || seen.stop(exit_code));
        own
    }

    /// Takes the end of standard input for a signal: whoever started this program holds the other end, and takes it along when it crashes.
    pub fn follow_stdin(&self, exit_code: u8) {
        let seen = self.clone();
        std::thread::spawn(move || {
            // What is written there means nothing; an error is an end too.
            let _ = std::io::copy(&mut std::io::stdin(), &mut std::io::sink());
            seen.stop(exit_code);
        });
    }

    fn stop(&self, exit_code: u8) {
        if self.cancel.swap(true, Ordering::SeqCst) || !self.rendering.load(Ordering::SeqCst) {
            super::console::print_error("interrupted");
            std::process::exit(i32::from(exit_code));
        }
    }
}
