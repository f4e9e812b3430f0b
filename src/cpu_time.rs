//! Seconds that processor cores have worked for this program: what a busy machine changes less than the clock on the wall.

/// Of all threads of the process; NaN where the system does not tell.
pub fn process_seconds() -> f64 {
    #[cfg(unix)]
    return seconds(rustix::time::ClockId::ProcessCPUTime);
    #[cfg(not(unix))]
    f64::NAN
}

/// Of the calling thread; NaN where the system does not tell.
pub fn thread_seconds() -> f64 {
    #[cfg(unix)]
    return seconds(rustix::time::ClockId::ThreadCPUTime);
    #[cfg(not(unix))]
    f64::NAN
}

#[cfg(unix)]
fn seconds(clock: rustix::time::ClockId) -> f64 {
    let t = rustix::time::clock_gettime(clock);
    t.tv_sec as f64 + t.tv_nsec as f64 * 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn work_takes_time_and_sleep_does_not() {
        let before = thread_seconds();
        std::thread::sleep(std::time::Duration::from_millis(30));
        let slept = thread_seconds() - before;
        let start = std::time::Instant::now();
        let mut sum = 0u64;
        while start.elapsed().as_millis() < 30 {
            sum = std::hint::black_box(sum + 1);
        }
        let worked = thread_seconds() - before - slept;
        assert!(worked > 2.0 * slept, "{worked} s of work, {slept} s of sleep");
        assert!(process_seconds() >= thread_seconds());
    }
}
