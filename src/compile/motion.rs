//! Objects that move while the shutter is open: keys taken apart so that rotations turn evenly between them.

use crate::math::{Bounds, DMat3, DVec3, Transform};
use crate::scene::Object;
use glam::{DAffine3, DQuat};

/// Steps over which a moving box is followed; what lies between them is covered by padding.
const SWEEP_STEPS: usize = 64;

/// A place taken apart: stretch first, then turn, then shift. Source: Shoemake and Duff 1992, polar decomposition.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Key {
    translation: DVec3,
    rotation: DQuat,
    stretch: DMat3,
}

impl Key {
    fn new(t: &Transform) -> Self {
        let m = t.forward.matrix3;
        // Newton's iteration to the nearest rotation (or rotated mirror).
        let mut r = m;
        for _ in 0..64 {
            let next = (r + r.inverse().transpose()) * 0.5;
            let done = next.abs_diff_eq(r, 1e-14);
            r = next;
            if done {
                break;
            }
        }
        if r.determinant() < 0.0 {
            r = -r;
        }
        let rotation = DQuat::from_mat3(&r).normalize();
        Self { translation: t.forward.translation, rotation, stretch: DMat3::from_quat(rotation).transpose() * m }
    }
}

/// How an object moves, in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    keys: Vec<Key>,
    /// World from the object at rest, inverted: `Object::transform` and all above.
    rest: Transform,
    above: Transform,
}

impl Motion {
    /// Of an object whose parent stands at `above`; `None` when it stands still.
    pub fn of_object(object: &Object, above: &Transform) -> Option<Self> {
        let keys = &object.traits.motion;
        (keys.len() > 1).then(|| Self { keys: keys.iter().map(Key::new).collect(), rest: object.transform.inverted(), above: *above })
    }

    /// Spans of equal time between its keys.
    pub fn n_spans(&self) -> usize {
        self.keys.len() - 1
    }

    /// World at `time` (0..=1 over the shutter) from the world at rest. A key that cannot be inverted leaves the object at rest.
    pub fn at(&self, time: f64) -> Transform {
        let x = time.clamp(0.0, 1.0) * (self.keys.len() - 1) as f64;
        let i = (x as usize).min(self.keys.len() - 2);
        let (a, b, f) = (&self.keys[i], &self.keys[i + 1], x - i as f64);
        let linear = DMat3::from_quat(a.rotation.slerp(b.rotation, f)) * (a.stretch * (1.0 - f) + b.stretch * f);
        let now = DAffine3 { matrix3: linear, translation: a.translation.lerp(b.translation, f) };
        match Transform::from_affine(now) {
            Some(now) => self.above.inverted().then(&self.rest).then(&now).then(&self.above),
            None => Transform::IDENTITY,
        }
    }

    /// A box around all places of a box at rest.
    pub fn swept(&self, b: &Bounds) -> Bounds {
        if b.is_empty() || b.is_unbounded() {
            return *b;
        }
        let all = (0..=SWEEP_STEPS).fold(Bounds::EMPTY, |all, k| all.union(b.transformed(&self.at(k as f64 / SWEEP_STEPS as f64))));
        let pad = (all.max - all.min) * 1e-3;
        Bounds { min: all.min - pad, max: all.max + pad }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Shape;

    #[test]
    fn a_spinning_object_turns_evenly_and_keeps_its_size() {
        let turn = |deg: f64| Transform::rotation_deg(DVec3::new(0.0, 0.0, deg)).then(&Transform::translation(DVec3::X));
        let mut o = Object::new(Shape::Sphere { center: DVec3::ZERO, radius: 1.0 });
        o.transform = turn(45.0);
        o.traits.motion = vec![turn(0.0), turn(90.0)].into();
        let m = Motion::of_object(&o, &Transform::IDENTITY).expect("it moves");
        let p = o.transform.point(DVec3::X);
        for (time, deg) in [(0.0, 0.0), (0.25, 22.5), (0.5, 45.0), (1.0, 90.0)] {
            let want = turn(deg).point(DVec3::X);
            assert!((m.at(time).point(p) - want).length() < 1e-12, "time {time}");
        }
    }
}
