//! The shadow rays to all points of an area light's grid, traced together where every point is wanted whatever the others show: small grids,
//! or larger ones whose `adaptive` level covers them. Random numbers are drawn in the order of the points asked one by one.

use super::lights::area_place;
use super::shadow::{AreaGrid, corners, quarters};
use super::shafts::Known;
use super::trace::Tracer;
use crate::accel::PACKET;
use crate::compile::{CompiledLight, CompiledScene, NONE};
use crate::kernel::light::{LightRay, area_offset, light_ray, unit_ways};
use crate::kernel::shadow_packet::intersect_shadows;
use crate::kernel::traverse::SHADOW_TOLERANCE;
use crate::math::{Rgb, Vec3};
use crate::savings::Saving;
use crate::scene::light::{AreaLight, LightKind};

/// Fewer rays are no packet.
const LEAST: usize = 4;

/// Grid points in the order in which the adaptive rule first asks for them; `None` where it may leave some out, or has too many or too few.
fn order_of_all(area: &AreaLight) -> Option<Vec<[u32; 2]>> {
    let n = area.n1.checked_mul(area.n2)? as usize;
    if !(LEAST..=PACKET).contains(&n) {
        return None;
    }
    let mut order = Vec::with_capacity(n);
    (visit(area.adaptive, [0, 0, area.n1 - 1, area.n2 - 1], 0, &mut order) && order.len() == n).then_some(order)
}

/// As `Tracer::area_part`; false where it depends on the colours.
fn visit(adaptive: u32, part: [u32; 4], level: u32, order: &mut Vec<[u32; 2]>) -> bool {
    for place in corners(part) {
        if !order.contains(&place) {
            order.push(place);
        }
    }
    let [u1, v1, u2, v2] = part;
    u2 - u1 <= 1 && v2 - v1 <= 1 || level < adaptive && quarters(part).iter().all(|p| visit(adaptive, *p, level + 1, order))
}

/// By light: the order of its grid's points, where they are traced together.
pub fn area_orders(scene: &CompiledScene) -> Vec<Option<Vec<[u32; 2]>>> {
    let of = |l: &CompiledLight| {
        let is_plain = l.projected_through == NONE && !l.light.shadowless && scene.options.savings.has(Saving::Shafts);
        l.light.area.as_ref().filter(|_| is_plain).and_then(order_of_all)
    };
    scene.lights.iter().map(of).collect()
}

impl Tracer<'_> {
    /// Fills in all points of a grid, if its light is one of those. Where all of them show the same, gives that, which is the mean.
    pub(super) fn area_points_together(&mut self, grid: &mut AreaGrid) -> Option<Rgb> {
        let (scene, plan) = (self.scene, self.plan);
        let order = plan.area_orders[grid.light_ix as usize].as_ref()?;
        if self.is_stopped() {
            return None;
        }
        let mut distance = [f64::NEG_INFINITY; PACKET];
        self.area_ways(grid, order, &mut distance);
        let mut far = [f64::NEG_INFINITY; PACKET];
        for k in 0..order.len() {
            far[k] = distance[k] - SHADOW_TOLERANCE;
        }
        let slot = usize::from(self.level > 1);
        let last = if scene.options.savings.has(Saving::Blockers) { self.blockers[grid.light_ix as usize][slot] } else { u32::MAX };
        let masks = intersect_shadows(scene, &self.area_packet, SHADOW_TOLERANCE, &far, last);
        if let Some(masks) = masks {
            if masks.blocker != u32::MAX {
                self.blockers[grid.light_ix as usize][slot] = masks.blocker;
            }
            // A mean of equal numbers, taken four by four, is that number to the last bit.
            if masks.blocked | masks.clear == 0 && self.is_air_clear() {
                return Some(grid.color);
            }
            let all = u64::MAX >> (PACKET - order.len());
            if masks.blocked == all && far[..order.len()].iter().all(|far| *far > SHADOW_TOLERANCE) {
                return Some(Vec3::ZERO);
            }
        }
        for (k, [u, v]) in order.iter().enumerate() {
            let known = match masks {
                Some(m) if m.blocked >> k & 1 == 1 => Known::Stopped(m.blocker),
                Some(m) if m.clear >> k & 1 == 0 => Known::Open,
                _ => Known::Nothing,
            };
            let c = match known {
                Known::Stopped(_) if far[k] > SHADOW_TOLERANCE => Vec3::ZERO,
                Known::Open if self.is_air_clear() => grid.color,
                _ => {
                    let way = LightRay { dir: self.area_packet.ray(k).dir, distance: distance[k] };
                    self.unshadowed(grid.light_ix, grid.around, grid.point, &way, grid.color, known)
                }
            };
            grid.points[(u * grid.area.n2 + v) as usize] = Some(c);
        }
        None
    }

    /// Makes the rays to the points of a grid, and says how far each is.
    fn area_ways(&mut self, grid: &AreaGrid, order: &[[u32; 2]], distance: &mut [f64; PACKET]) {
        let light = &self.scene.lights[grid.light_ix as usize].light;
        let Self { area_packet, random, .. } = self;
        let is_point = matches!(light.kind, LightKind::Point | LightKind::Spot { .. }) && !light.parallel;
        area_packet.set_from(grid.point, order.len(), |dirs| {
            for (k, [u, v]) in order.iter().enumerate() {
                let (u, v) = (area_place(random, *u, grid.area.jitter), area_place(random, *v, grid.area.jitter));
                let offset = area_offset(grid.area, grid.axes, u, v);
                let to = if is_point {
                    light.location + offset - grid.point
                } else {
                    let way = light_ray(light, grid.point, offset);
                    distance[k] = way.distance;
                    way.dir
                };
                (dirs[0][k], dirs[1][k], dirs[2][k]) = to.into();
            }
            if is_point {
                unit_ways(dirs, distance, order.len());
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec3;

    #[test]
    fn grids_that_are_always_asked_in_full_are_known() {
        let area = |n1: u32, n2: u32, adaptive: u32| AreaLight {
            axis1: DVec3::X,
            axis2: DVec3::Z,
            n1,
            n2,
            adaptive,
            jitter: true,
            circular: false,
            orient: false,
            area_illumination: false,
        };
        let n = |n1, n2, adaptive| order_of_all(&area(n1, n2, adaptive)).map(|o| o.len());
        assert_eq!((n(2, 2, 0), n(3, 3, 1), n(4, 4, 1), n(5, 5, 2), n(8, 8, 100)), (Some(4), Some(9), Some(16), Some(25), Some(64)));
        // The middle is asked only where the corners differ; too many; too few.
        assert_eq!((n(3, 3, 0), n(5, 5, 1), n(9, 9, 100), n(1, 3, 100)), (None, None, None, None));
        let order = order_of_all(&area(3, 3, 1)).expect("nine points");
        assert_eq!(order[..5], [[0, 0], [2, 0], [0, 2], [2, 2], [1, 0]]);
    }
}
