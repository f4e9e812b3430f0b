//! The CPU back end: rayon over blocks of pixels, f64 geometry, the same picture whatever the thread count.
