//! The order of POV-Ray's bounding hierarchy. It shows where a camera stands inside several objects: their interiors are entered in that
//! order, and the one entered last bends light on its way out.
//!
//! Measured (POV-Ray 3.7.0.10; 126 scenes of three balls around the camera among up to 30 others, all orders tried): what has no end
//! comes first, as in the file. The rest is sorted by the middles of the boxes along an axis and parted where surface areas times numbers
//! are least, as long as that is less than the area of the whole times three fewer than there are; parts become nodes, and nodes are
//! treated like objects until one is left. The axis is the one of the largest difference between two corners, see [`widest_axis`].

use super::super::extent::pov_extent_in;
use super::super::geometry::Geometry;
use super::is_taken_apart;
use crate::math::{Bounds, Transform};
use crate::scene::{Light, Object, Projection, Scene, Shape};
use glam::Vec3;

/// Items that are never parted.
const BUNCH: usize = 4;
/// Sorting may look at this many items for each one that there is; uneven parting of very many is given up, as is its order.
const WORK: usize = 400;

/// A box and what it holds: the items of `held`, or, without any, an object.
struct Item {
    low: Vec3,
    size: Vec3,
    held: Option<std::ops::Range<u32>>,
    object: u32,
}

impl Item {
    fn high(&self) -> Vec3 {
        self.low + self.size
    }

    fn middle(&self, axis: usize) -> f32 {
        self.low[axis] + self.size[axis] / 2.0
    }
}

/// Corners of a box that grows around items.
#[derive(Clone, Copy)]
struct Hull(Vec3, Vec3);

impl Hull {
    const EMPTY: Self = Self(Vec3::MAX, Vec3::MIN);

    fn including(self, item: &Item) -> Self {
        Self(self.0.min(item.low), self.1.max(item.high()))
    }

    /// Half the surface.
    fn half_area(self) -> f64 {
        let s = (self.1 - self.0).as_dvec3();
        s.x * (s.y + s.z) + s.y * s.z
    }
}

/// The axis along which items are sorted: the largest difference between the lower corner of the last item whose upper corner exceeds
/// the "largest" so far (which is set to that lower corner) and the least lower corner. POV-Ray's own rule, found by trying.
fn widest_axis(items: &[Item]) -> usize {
    let (mut least, mut most) = (Vec3::MAX, Vec3::MIN);
    for item in items {
        least = least.min(item.low);
        most = Vec3::select(item.high().cmpgt(most), item.low, most);
    }
    (most - least).max_position()
}

/// How many of the sorted items make the first part; `None`: they stay together.
fn parting(items: &[Item]) -> Option<usize> {
    let n = items.len();
    if n <= BUNCH {
        return None;
    }
    let mut above = vec![0.0; n];
    let mut hull = Hull::EMPTY;
    for (k, item) in items.iter().enumerate().rev() {
        hull = hull.including(item);
        above[k] = hull.half_area();
    }
    let (mut best, mut least) = (None, (n as f64 - 3.0) * above[0]);
    hull = Hull::EMPTY;
    for k in 1..n {
        hull = hull.including(&items[k - 1]);
        let cost = k as f64 * hull.half_area() + (n - k) as f64 * above[k];
        if cost < least {
            (best, least) = (Some(k), cost);
        }
    }
    best
}

/// Objects in the order of the hierarchy over their boxes; `None` where that would take too long.
fn order(boxes: &[Bounds]) -> Option<Vec<u32>> {
    let (endless, bounded): (Vec<u32>, Vec<u32>) = (0..boxes.len() as u32).partition(|k| boxes[*k as usize].is_unbounded());
    let item = |k: u32| {
        let b = &boxes[k as usize];
        let low = b.min.as_vec3();
        Item { low, size: b.max.as_vec3() - low, held: None, object: k }
    };
    let mut items: Vec<Item> = bounded.into_iter().map(item).collect();
    // Nodes move when they are sorted, what they hold does not: it lies before them.
    let (mut from, mut work) = (0, WORK * items.len());
    while from < items.len() {
        let end = items.len();
        let mut parts = vec![(from, end)];
        let mut n_nodes = 0;
        while let Some((a, b)) = parts.pop() {
            work = work.checked_sub(b - a)?;
            let axis = widest_axis(&items[a..b]);
            items[a..b].sort_by(|x, y| x.middle(axis).total_cmp(&y.middle(axis)));
            match parting(&items[a..b]) {
                Some(k) => parts.extend([(a + k, b), (a, a + k)]),
                None => {
                    let Hull(low, high) = items[a..b].iter().fold(Hull::EMPTY, Hull::including);
                    items.push(Item { low, size: high - low, held: Some(a as u32..b as u32), object: 0 });
                    n_nodes += 1;
                }
            }
        }
        if n_nodes == 1 {
            break;
        }
        from = end;
    }
    let mut order = endless;
    let mut open: Vec<usize> = items.len().checked_sub(1).into_iter().collect();
    while let Some(k) = open.pop() {
        match &items[k].held {
            Some(held) => open.extend(held.clone().rev().map(|k| k as usize)),
            None => order.push(items[k].object),
        }
    }
    Some(order)
}

/// Sorts a scene's solids as the hierarchy has them, where the camera may stand in two of them.
pub(super) fn sort_solids(geometry: &mut Geometry, scene: &Scene) {
    let camera = &scene.camera;
    let roams = camera.blur.is_some()
        || matches!(camera.projection, Projection::Orthographic | Projection::Cylinder { .. } | Projection::Mesh { .. });
    let around = geometry.solids.iter().filter(|(b, _)| roams || b.contains(camera.location));
    if around.count() < 2 {
        return;
    }
    let visible: Vec<usize> = (0..geometry.objects.len()).filter(|k| geometry.objects[*k].visible).collect();
    let boxes = boxes(scene);
    debug_assert_eq!(boxes.len(), visible.len());
    let Some(order) = order(&boxes) else { return };
    let mut ranks = vec![u32::MAX; geometry.objects.len()];
    for (rank, k) in (0..).zip(order) {
        if let Some(object) = visible.get(k as usize) {
            ranks[*object] = rank;
        }
    }
    geometry.solids.sort_by_key(|(_, object)| ranks[*object as usize]);
}

/// POV-Ray's boxes of the objects at the top, unions taken apart, in the order in which they are compiled.
fn boxes(scene: &Scene) -> Vec<Bounds> {
    let mut boxes = Vec::new();
    for light in &scene.lights {
        add_light(light, &Transform::IDENTITY, &mut boxes);
    }
    for object in &scene.objects {
        add(object, &Transform::IDENTITY, &mut boxes);
    }
    boxes
}

fn add_light(light: &Light, to_world: &Transform, boxes: &mut Vec<Bounds>) {
    if let Some(object) = &light.looks_like {
        add(object, to_world, boxes);
    }
}

fn add(object: &Object, to_world: &Transform, boxes: &mut Vec<Bounds>) {
    let apart = is_taken_apart(object);
    let inside = object.transform.then(to_world);
    match &object.shape {
        Shape::Csg { children, .. } if apart => children.iter().for_each(|c| add(c, &inside, boxes)),
        Shape::Group { child } if apart => add(child, &inside, boxes),
        Shape::LightGroup { children, lights, .. } if apart => {
            lights.iter().for_each(|l| add_light(l, &inside, boxes));
            children.iter().for_each(|c| add(c, &inside, boxes));
        }
        Shape::Light(light) => add_light(light, &inside, boxes),
        _ => boxes.push(pov_extent_in(object, to_world)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::DVec3;

    fn ball(x: f64, y: f64, z: f64, r: f64) -> Bounds {
        Bounds { min: DVec3::new(x, y, z) - r, max: DVec3::new(x, y, z) + r }
    }

    #[test]
    fn orders_are_those_that_were_measured() {
        // Three balls around the camera each; the only order of six that gives POV-Ray's picture.
        let along_y = [ball(0.709, 0.238, 0.641, 1.299), ball(0.197, 0.387, 0.472, 1.784), ball(0.384, 0.676, -0.754, 1.748)];
        assert_eq!(order(&along_y).unwrap(), [0, 1, 2], "although z is the longest axis");
        let along_x = [ball(-0.694, -0.157, 0.669, 1.977), ball(0.424, -0.445, 0.059, 1.094), ball(-0.422, -0.635, -0.166, 1.135)];
        assert_eq!(order(&along_x).unwrap(), [0, 2, 1]);
    }

    #[test]
    fn what_has_no_end_comes_first_and_equals_stay() {
        let b = ball(1.0, 0.0, 0.0, 1.0);
        assert_eq!(order(&[b, Bounds::UNBOUNDED, ball(-1.0, 0.0, 0.0, 1.0), b, Bounds::UNBOUNDED]).unwrap(), [1, 4, 2, 0, 3]);
        assert_eq!(order(&[]).unwrap(), [0u32; 0]);
    }

    #[test]
    fn all_objects_come_once_however_many() {
        let far: Vec<Bounds> =
            (0..2000).map(|k| ball(f64::from(k * 7919 % 1000), f64::from(k * 104_729 % 777), f64::from(k % 91), 0.5)).collect();
        let mut all = order(&far).unwrap();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..2000));
    }
}
