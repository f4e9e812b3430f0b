//! Photons where they came to rest, in a flat kd-tree, and the search for those nearest to a point. Nothing here traces a ray.
//!
//! The tree is the array itself: the middle of a range is its node, what lies before it is on the low side of the node's axis.
//! Source: Bentley 1975; Jensen 2001, "Realistic Image Synthesis Using Photon Mapping", for what is kept of a photon.

use crate::math::{DVec3, Rgb, Vec3};
use std::sync::LazyLock;

/// A photon as POV-Ray keeps it: place in single precision, colour in 8 bits a channel under one exponent, direction in 16 bits.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Photon {
    position: [f32; 3],
    /// Three mantissas and the exponent. Source: Ward 1991, "Real Pixels".
    power: [u8; 4],
    /// Where it came from: angle about y, elevation, in 1/127 of pi.
    from: [i8; 2],
    /// Axis of the tree's node here.
    axis: u8,
}

impl Photon {
    /// A photon at `position` that came from unit direction `from`.
    pub fn new(position: DVec3, power: Rgb, from: DVec3) -> Self {
        Self { position: position.as_vec3().to_array(), power: pack_power(power), from: pack_direction(from), axis: 0 }
    }

    /// Its place.
    #[inline]
    pub fn position(&self) -> DVec3 {
        Vec3::from(self.position).as_dvec3()
    }

    /// Its light.
    #[inline]
    pub fn power(&self) -> Rgb {
        let [r, g, b, exponent] = self.power;
        if exponent == 0 {
            return Vec3::ZERO;
        }
        // 2^(exponent - 136), put together from its bits; the least exponents are 0.
        let scale = f32::from_bits(u32::from(exponent.saturating_sub(9)) << 23);
        Vec3::new(f32::from(r), f32::from(g), f32::from(b)) * scale
    }

    /// Unit direction that it came from.
    #[inline]
    pub fn from(&self) -> DVec3 {
        let [(sin, cos), (y, level)] = self.from.map(|v| ANGLES[usize::from(v as u8)]);
        DVec3::new(level * cos, y, level * sin)
    }
}

/// Sine and cosine of the angles that a photon's direction may have, by the byte.
static ANGLES: LazyLock<[(f64, f64); 256]> =
    LazyLock::new(|| std::array::from_fn(|k| (f64::from(k as u8 as i8) * std::f64::consts::PI / 127.0).sin_cos()));

/// Mantissas are cut off, not rounded: light is lost that POV-Ray loses too.
fn pack_power(c: Rgb) -> [u8; 4] {
    let brightest = c.max_element();
    // Below 2^-118 the exponent has no place; NaN and infinity are no light.
    if !(1e-35..=f32::MAX).contains(&brightest) {
        return [0; 4];
    }
    let exponent = (brightest.to_bits() >> 23) as i32 - 126;
    let scale = f32::from_bits(((8 - exponent + 127).clamp(1, 254) as u32) << 23);
    let [r, g, b] = (c.max(Vec3::ZERO) * scale).to_array().map(|v| v as u8);
    [r, g, b, (exponent + 128).clamp(0, 255) as u8]
}

fn pack_direction(d: DVec3) -> [i8; 2] {
    let units = 127.0 / std::f64::consts::PI;
    [d.z.atan2(d.x), d.y.clamp(-1.0, 1.0).asin()].map(|a| (a * units) as i8)
}

/// Photons as a kd-tree.
#[derive(Clone, Debug, Default)]
pub struct PhotonMap {
    photons: Vec<Photon>,
}

/// Ranges of more photons are split on two cores.
const PARALLEL: usize = 1 << 14;
/// Ranges no longer than this are looked through.
const LEAF: usize = 8;

impl PhotonMap {
    /// Bytes that a map takes for each photon.
    pub const PHOTON_BYTES: usize = size_of::<Photon>();

    /// Builds the tree: `n log n`, in place, the same on any number of threads.
    pub fn build(mut photons: Vec<Photon>) -> Self {
        split(&mut photons);
        Self { photons }
    }

    /// Number of photons.
    pub fn len(&self) -> usize {
        self.photons.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.photons.is_empty()
    }

    /// All photons, in the tree's order.
    pub fn photons(&self) -> &[Photon] {
        &self.photons
    }

    /// Fills `found` with the photons nearest to `p`, as many as it may hold, no farther than `radius`.
    ///
    /// With a `flat` normal, squared distances are multiplied by `1 + 16 |normal · v|`, `v` being the way to the photon in scene units:
    /// what lies above or below the surface counts as farther. Source: spec/light.md, section 9.
    pub fn nearest(&self, p: DVec3, flat: Option<DVec3>, radius: f64, found: &mut NearestPhotons) {
        found.start(radius * radius);
        let mut stack = [(0u32, 0u32, 0.0f64); 64];
        stack[0] = (0, self.photons.len() as u32, 0.0);
        let mut n = 1;
        while n > 0 {
            n -= 1;
            let (mut low, mut high, gap_sq) = stack[n];
            if gap_sq >= found.limit_sq {
                continue;
            }
            while (high - low) as usize > LEAF {
                let middle = low + (high - low) / 2;
                let photon = &self.photons[middle as usize];
                let axis = usize::from(photon.axis);
                let gap = p[axis] - f64::from(photon.position[axis]);
                let (near, far) = if gap < 0.0 { ((low, middle), (middle + 1, high)) } else { ((middle + 1, high), (low, middle)) };
                if gap * gap < found.limit_sq {
                    stack[n] = (far.0, far.1, gap * gap);
                    n += 1;
                    found.offer(p, flat, photon, middle);
                }
                (low, high) = near;
            }
            for k in low..high {
                found.offer(p, flat, &self.photons[k as usize], k);
            }
        }
        found.keep_nearest();
    }
}

/// Makes a range a tree.
fn split(photons: &mut [Photon]) {
    if photons.len() <= LEAF {
        return;
    }
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for p in photons.iter() {
        low = low.min(p.position.into());
        high = high.max(p.position.into());
    }
    let extent = high - low;
    let axis = if extent.x >= extent.y && extent.x >= extent.z {
        0
    } else if extent.y >= extent.z {
        1
    } else {
        2
    };
    let middle = photons.len() / 2;
    photons.select_nth_unstable_by(middle, |a, b| a.position[axis].total_cmp(&b.position[axis]));
    photons[middle].axis = axis as u8;
    let (before, rest) = photons.split_at_mut(middle);
    let after = &mut rest[1..];
    if before.len() > PARALLEL {
        rayon::join(|| split(before), || split(after));
    } else {
        split(before);
        split(after);
    }
}

/// The photons nearest to a point.
///
/// More than are wanted are kept for a while: each time the list is full the farthest are thrown out together, which takes a few steps a photon,
/// where a heap takes as many as it has levels.
#[derive(Clone, Debug, Default)]
pub struct NearestPhotons {
    /// Squared distance, place in the map.
    items: Vec<(f64, u32)>,
    most: usize,
    /// Items that the list holds before the farthest go.
    room: usize,
    limit_sq: f64,
}

impl NearestPhotons {
    /// Room for `most`, at least one.
    pub fn new(most: u32) -> Self {
        let most = most.max(1) as usize;
        Self { items: Vec::new(), most, room: most.saturating_add(most.max(32)), limit_sq: 0.0 }
    }

    fn start(&mut self, limit_sq: f64) {
        self.items.clear();
        self.limit_sq = limit_sq;
    }

    /// How many were found.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Square of the radius that was searched, or of the distance of the farthest that was kept when there was no room for more.
    pub fn radius_sq(&self) -> f64 {
        self.limit_sq
    }

    /// Their places in the map.
    pub fn places(&self) -> impl Iterator<Item = usize> + '_ {
        self.items.iter().map(|(_, k)| *k as usize)
    }

    #[inline]
    fn offer(&mut self, p: DVec3, flat: Option<DVec3>, photon: &Photon, place: u32) {
        let v = photon.position() - p;
        let mut d = v.length_squared();
        if d >= self.limit_sq {
            return;
        }
        if let Some(n) = flat {
            d *= 1.0 + 16.0 * n.dot(v).abs();
            if d >= self.limit_sq {
                return;
            }
        }
        self.items.push((d, place));
        if self.items.len() == self.most || self.items.len() >= self.room {
            self.keep_nearest();
        }
    }

    /// Throws out all but the nearest that are wanted, if there are as many; what comes then must be nearer than those.
    #[inline(never)]
    fn keep_nearest(&mut self) {
        if self.items.len() < self.most {
            return;
        }
        // Bits of numbers that are not negative are in order.
        let (_, farthest, _) = self.items.select_nth_unstable_by_key(self.most - 1, |i| i.0.to_bits());
        self.limit_sq = farthest.0;
        self.items.truncate(self.most);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix64;

    fn cloud(n: usize) -> Vec<Photon> {
        let mut r = SplitMix64(7);
        (0..n).map(|_| Photon::new(r.cube() * DVec3::new(1.0, 0.2, 3.0), Vec3::ONE, DVec3::Y)).collect()
    }

    #[test]
    fn the_tree_finds_what_looking_at_all_photons_finds() {
        let all = cloud(3000);
        let map = PhotonMap::build(all.clone());
        let mut r = SplitMix64(9);
        let mut found = NearestPhotons::new(40);
        let mut n_full = 0;
        for k in 0..300 {
            let (p, radius) = (r.cube() * DVec3::new(1.1, 0.3, 3.1), 0.1 + 0.5 * r.unit());
            let flat = (k % 2 == 1).then(|| r.direction());
            map.nearest(p, flat, radius, &mut found);
            let mut want: Vec<f64> = all
                .iter()
                .map(|q| {
                    let v = q.position() - p;
                    v.length_squared() * flat.map_or(1.0, |n| 1.0 + 16.0 * n.dot(v).abs())
                })
                .filter(|d| *d < radius * radius)
                .collect();
            want.sort_by(f64::total_cmp);
            let is_full = want.len() >= 40;
            n_full += u32::from(is_full);
            want.truncate(40);
            let mut got: Vec<f64> = found.items.iter().map(|(d, _)| *d).collect();
            got.sort_by(f64::total_cmp);
            assert_eq!(got, want);
            assert_eq!(found.radius_sq(), if is_full { want[39] } else { radius * radius });
        }
        assert!((50..250).contains(&n_full), "both full and partly filled heaps are tried: {n_full}");
    }

    #[test]
    fn the_tree_does_not_depend_on_the_number_of_threads() {
        let build = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| PhotonMap::build(cloud(100_000))).photons
        };
        assert_eq!(build(1), build(3));
    }

    #[test]
    fn colours_lose_less_than_a_128th_of_their_brightest_channel_and_gain_nothing() {
        let mut r = SplitMix64(3);
        for k in -30..30 {
            let c = Vec3::new(r.unit() as f32, r.unit() as f32, r.unit() as f32) * 2f32.powi(k) * 1.3;
            let got = Photon::new(DVec3::ZERO, c, DVec3::Y).power();
            let lost = c - got;
            assert!(lost.min_element() >= 0.0 && lost.max_element() <= c.max_element() / 127.9, "{c} became {got}");
        }
        assert_eq!(Photon::new(DVec3::ZERO, Vec3::ZERO, DVec3::Y).power(), Vec3::ZERO);
        assert_eq!(Photon::new(DVec3::ZERO, Vec3::splat(f32::NAN), DVec3::Y).power(), Vec3::ZERO);
        assert_eq!(Photon::new(DVec3::ZERO, Vec3::splat(f32::INFINITY), DVec3::Y).power(), Vec3::ZERO);
    }

    #[test]
    fn directions_are_kept_to_two_degrees() {
        let mut r = SplitMix64(5);
        for _ in 0..1000 {
            let d = r.direction();
            let got = Photon::new(DVec3::ZERO, Vec3::ONE, d).from();
            assert!(got.dot(d) > 2.1f64.to_radians().cos(), "{d} became {got}");
        }
    }
}
