//! The frames of an animation and their clocks. Source: spec/language.md, section 11.2.

use super::{OptionError, PovOptions};

/// Most frames of a run.
const MAX_FRAMES: usize = 1_000_000;

/// One picture of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// `frame_number`; 0 without animation.
    pub number: i32,
    /// `clock`, worked out in double precision, kept in single.
    pub clock: f64,
    /// Whether `clock_on`.
    pub clock_on: bool,
    /// `frame_number`, `initial_frame`, `final_frame`, `clock_delta`, `initial_clock`, `final_clock` as a scene sees them.
    pub variables: [f64; 6],
    /// Digits of the frame number in the picture's name; 0 without animation.
    pub digits: usize,
}

/// All frames that the options ask for: one without animation, none for an empty subset.
pub fn frames(o: &PovOptions) -> Result<Vec<Frame>, OptionError> {
    if !o.is_animation() {
        let clock = f64::from(o.clock as f32);
        return Ok(vec![Frame { number: 0, clock, clock_on: o.clock_on, variables: [0.0; 6], digits: 0 }]);
    }
    let (first, last) = (o.initial_frame, o.final_frame);
    // A cyclic run ends one step before its first picture comes again.
    let counted_last = if o.cyclic { last.saturating_add(1) } else { last };
    let delta = (o.final_clock - o.initial_clock) / (f64::from(counted_last) - f64::from(first));
    let count = f64::from(last) - f64::from(first) + 1.0;
    let place = |v: f64, otherwise: i32| match v {
        0.0 => otherwise,
        v if v < 1.0 => (count * v) as i32,
        v => v as i32,
    };
    let from = place(o.subset_start, first).max(first);
    let to = place(o.subset_end, last).min(last);
    let digits = counted_last.to_string().len();
    let numbers = (from..=to).step_by(o.frame_step.max(1) as usize);
    if numbers.clone().nth(MAX_FRAMES).is_some() {
        return Err(OptionError::TooManyFrames(MAX_FRAMES));
    }
    Ok(numbers
        .map(|number| {
            let clock = o.initial_clock + delta * (f64::from(number) - f64::from(first));
            let variables = [f64::from(number), f64::from(first), f64::from(counted_last), delta, o.initial_clock, o.final_clock];
            Frame { number, clock: f64::from(clock as f32), clock_on: true, variables, digits }
        })
        .collect())
}
