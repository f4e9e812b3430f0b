//! A tree over lamps and shining triangles: one is drawn with a chance near its share of the light that arrives.
//!
//! Source: Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting" (without the splitting).

use crate::math::{Bounds, DVec3};
use std::f64::consts::PI;

/// What the tree knows of one light.
#[derive(Clone, Copy, Debug)]
pub struct TreeLight {
    /// World box.
    pub bounds: Bounds,
    /// Unit; middle of the directions along which it shines most.
    pub axis: DVec3,
    /// How far from `axis` those directions reach, radians; π for all.
    pub spread_rad: f64,
    /// How far beyond them light reaches, radians.
    pub reach_rad: f64,
    /// Greatest intensity.
    pub energy: f64,
}

/// A cone of directions around one.
#[derive(Clone, Copy, Debug)]
struct Cone {
    axis: DVec3,
    spread: f64,
    reach: f64,
}

impl Cone {
    fn merged(a: Cone, b: Cone) -> Cone {
        let (a, b) = if a.spread >= b.spread { (a, b) } else { (b, a) };
        let apart = a.axis.dot(b.axis).clamp(-1.0, 1.0).acos();
        let reach = a.reach.max(b.reach);
        if (apart + b.spread).min(PI) <= a.spread {
            return Cone { reach, ..a };
        }
        let spread = 0.5 * (a.spread + apart + b.spread);
        if spread >= PI {
            return Cone { axis: a.axis, spread: PI, reach };
        }
        let turn = spread - a.spread;
        match a.axis.cross(b.axis).try_normalize() {
            Some(about) => Cone { axis: glam::DQuat::from_axis_angle(about, turn) * a.axis, spread, reach },
            None => Cone { axis: a.axis, spread: PI, reach },
        }
    }

    /// Measure of a cone's directions, weighed by their light.
    fn measure(&self) -> f64 {
        let (o, w) = (self.spread, (self.spread + self.reach).min(PI));
        2.0 * PI * (1.0 - o.cos()) + 0.5 * PI * (2.0 * w * o.sin() - (o - 2.0 * w).cos() - 2.0 * o * o.sin() + o.cos())
    }
}

/// A node: what is below it, in a ball and a cone of directions.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Of the ball around the lights.
    pub center: DVec3,
    /// Half the diagonal.
    pub radius: f64,
    /// Unit; middle of the cone.
    pub axis: DVec3,
    /// Of the cone.
    pub cos_spread: f64,
    /// Of the cone.
    pub sin_spread: f64,
    /// Of how far light reaches beyond the cone.
    pub cos_reach: f64,
    /// Sum of the lights'.
    pub energy: f64,
    /// Second child; the first follows the node. `u32::MAX` for a leaf.
    pub right: u32,
    /// Parent, `u32::MAX` at the root.
    pub parent: u32,
    /// Of a leaf.
    pub light: u32,
}

/// The tree.
#[derive(Clone, Debug, Default)]
pub struct LightTree {
    nodes: Vec<Node>,
    /// Leaf of each light.
    leaves: Vec<u32>,
}

/// Never none: what bounds miss (bent normals) must stay possible.
const LEAST_COS: f64 = 0.03;

impl LightTree {
    /// Over `lights`.
    pub fn new(lights: &[TreeLight]) -> Self {
        let mut tree = Self { nodes: Vec::with_capacity(2 * lights.len()), leaves: vec![u32::MAX; lights.len()] };
        let mut order: Vec<u32> = (0..lights.len() as u32).collect();
        if !order.is_empty() {
            tree.build(lights, &mut order, u32::MAX);
        }
        tree
    }

    /// Whether there is nothing to draw.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// All nodes, the root first.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Leaf of each light.
    pub fn leaves(&self) -> &[u32] {
        &self.leaves
    }

    /// Middle of the box of all lights.
    pub fn center(&self) -> Option<DVec3> {
        self.nodes.first().map(|n| n.center)
    }

    fn build(&mut self, lights: &[TreeLight], order: &mut [u32], parent: u32) {
        let of = |k: u32| &lights[k as usize];
        let all = summed(order.iter().map(|k| of(*k)));
        let at = self.nodes.len() as u32;
        self.nodes.push(Node {
            center: 0.5 * (all.0.min + all.0.max),
            radius: 0.5 * (all.0.max - all.0.min).length(),
            axis: all.1.axis,
            cos_spread: all.1.spread.cos(),
            sin_spread: all.1.spread.sin(),
            cos_reach: all.1.reach.min(PI).cos(),
            energy: all.2,
            right: u32::MAX,
            parent,
            light: order[0],
        });
        if order.len() == 1 {
            self.leaves[order[0] as usize] = at;
            return;
        }
        let middle = split(lights, order);
        let (a, b) = order.split_at_mut(middle);
        self.build(lights, a, at);
        self.nodes[at as usize].right = self.nodes.len() as u32;
        self.build(lights, b, at);
    }

    /// About the irradiance at `p` on a surface with normal `n` (none in volumes) from all below a node.
    #[inline]
    fn importance(&self, node: &Node, p: DVec3, n: Option<DVec3>) -> f64 {
        let to = node.center - p;
        let d_sq = to.length_squared();
        let r_sq = node.radius * node.radius;
        // Inside the ball every direction is possible.
        if d_sq <= r_sq || d_sq == 0.0 {
            return node.energy / r_sq.max(1e-12);
        }
        let dir = to / d_sq.sqrt();
        let sin_u_sq = r_sq / d_sq;
        let (sin_u, cos_u) = (sin_u_sq.sqrt(), (1.0 - sin_u_sq).sqrt());
        // Cosine of an angle less the ball's, no less than none.
        let less = |cos: f64, sin: f64, cos_b: f64, sin_b: f64| {
            if cos >= cos_b { (1.0, 0.0) } else { (cos * cos_b + sin * sin_b, sin * cos_b - cos * sin_b) }
        };
        let mut leaving = 1.0;
        if node.cos_spread > -1.0 {
            let cos = -dir.dot(node.axis);
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            let (cos, sin) = less(cos, sin, node.cos_spread, node.sin_spread);
            let (cos, _) = less(cos, sin, cos_u, sin_u);
            if cos <= node.cos_reach {
                return 0.0;
            }
            leaving = cos.max(0.05);
        }
        let arriving = n.map_or(1.0, |n| {
            let cos = dir.dot(n);
            less(cos, (1.0 - cos * cos).max(0.0).sqrt(), cos_u, sin_u).0.max(LEAST_COS)
        });
        node.energy * leaving * arriving / d_sq
    }

    /// About the irradiance from all lights.
    pub fn estimate(&self, p: DVec3, n: Option<DVec3>) -> f64 {
        if self.nodes.is_empty() {
            return 0.0;
        }
        self.estimate_below(0, p, n, 4)
    }

    fn estimate_below(&self, at: u32, p: DVec3, n: Option<DVec3>, depth: u32) -> f64 {
        let node = &self.nodes[at as usize];
        if depth == 0 || node.right == u32::MAX {
            return self.importance(node, p, n);
        }
        self.estimate_below(at + 1, p, n, depth - 1) + self.estimate_below(node.right, p, n, depth - 1)
    }

    /// Chance of the first child.
    #[inline]
    fn chance_left(&self, at: u32, p: DVec3, n: Option<DVec3>) -> Option<f64> {
        let node = &self.nodes[at as usize];
        let a = self.importance(&self.nodes[at as usize + 1], p, n);
        let b = self.importance(&self.nodes[node.right as usize], p, n);
        let sum = a + b;
        (sum > 0.0).then(|| a / sum)
    }

    /// Draws a light; gives it with its chance, and what is left of `u`.
    pub fn sample(&self, p: DVec3, n: Option<DVec3>, u: f64) -> Option<(u32, f64)> {
        if self.nodes.is_empty() {
            return None;
        }
        let (mut at, mut chance, mut u) = (0u32, 1.0, u);
        loop {
            let node = &self.nodes[at as usize];
            if node.right == u32::MAX {
                return Some((node.light, chance));
            }
            let left = self.chance_left(at, p, n)?;
            if u < left {
                u /= left;
                chance *= left;
                at += 1;
            } else {
                u = ((u - left) / (1.0 - left)).min(1.0 - 1e-12);
                chance *= 1.0 - left;
                at = node.right;
            }
        }
    }

    /// Chance with which [`Self::sample`] draws `light`.
    pub fn chance(&self, light: u32, p: DVec3, n: Option<DVec3>) -> f64 {
        let mut at = self.leaves[light as usize];
        let mut chance = 1.0;
        loop {
            let parent = self.nodes[at as usize].parent;
            if parent == u32::MAX {
                return chance;
            }
            let Some(left) = self.chance_left(parent, p, n) else { return 0.0 };
            chance *= if at == parent + 1 { left } else { 1.0 - left };
            at = parent;
        }
    }
}

fn cone_of(l: &TreeLight) -> Cone {
    Cone { axis: l.axis, spread: l.spread_rad, reach: l.reach_rad }
}

fn summed<'l>(lights: impl Iterator<Item = &'l TreeLight>) -> (Bounds, Cone, f64) {
    let mut all: Option<(Bounds, Cone, f64)> = None;
    for l in lights {
        all = Some(match all {
            None => (l.bounds, cone_of(l), l.energy),
            Some((b, c, e)) => (b.union(l.bounds), Cone::merged(c, cone_of(l)), e + l.energy),
        });
    }
    all.expect("a node has lights")
}

/// Orders lights by the best of a few cuts along each axis; gives the first of the second part.
fn split(lights: &[TreeLight], order: &mut [u32]) -> usize {
    const BINS: usize = 12;
    let center = |k: u32| 0.5 * (lights[k as usize].bounds.min + lights[k as usize].bounds.max);
    let span = Bounds::from_points(order.iter().map(|k| center(*k)));
    let size = span.max - span.min;
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in 0..3 {
        if !(size[axis] > 0.0) {
            continue;
        }
        let bin = |k: u32| (((center(k)[axis] - span.min[axis]) / size[axis] * BINS as f64) as usize).min(BINS - 1);
        // Long thin nodes are cut across. Source: the paper's regularisation.
        let regular = size.max_element() / size[axis];
        let mut parts: [Option<(Bounds, Cone, f64)>; BINS] = [None; BINS];
        for k in order.iter() {
            let l = &lights[*k as usize];
            let p = &mut parts[bin(*k)];
            *p = Some(match *p {
                None => (l.bounds, cone_of(l), l.energy),
                Some((b, c, e)) => (b.union(l.bounds), Cone::merged(c, cone_of(l)), e + l.energy),
            });
        }
        let join = |a: Option<(Bounds, Cone, f64)>, b: Option<(Bounds, Cone, f64)>| match (a, b) {
            (Some(a), Some(b)) => Some((a.0.union(b.0), Cone::merged(a.1, b.1), a.2 + b.2)),
            (a, b) => a.or(b),
        };
        let cost = |p: Option<(Bounds, Cone, f64)>| {
            p.map_or(0.0, |(b, c, e)| {
                let s = b.max - b.min;
                e * (s.x * s.y + s.y * s.z + s.z * s.x).max(1e-12) * c.measure()
            })
        };
        let mut after = [None; BINS + 1];
        for i in (0..BINS).rev() {
            after[i] = join(parts[i], after[i + 1]);
        }
        let mut before = None;
        for cut in 1..BINS {
            before = join(before, parts[cut - 1]);
            if before.is_none() || after[cut].is_none() {
                continue;
            }
            let c = regular * (cost(before) + cost(after[cut]));
            if best.is_none_or(|b| c < b.0) {
                best = Some((c, axis, cut));
            }
        }
    }
    let Some((_, axis, cut)) = best else { return order.len() / 2 };
    order.sort_by(|a, b| center(*a)[axis].total_cmp(&center(*b)[axis]));
    let n = order.iter().filter(|k| (center(**k)[axis] - span.min[axis]) / size[axis] * (BINS as f64) < cut as f64).count();
    n.clamp(1, order.len() - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::sobol::Pcg;

    #[test]
    fn chances_are_those_drawn_with_and_add_up() {
        let mut r = Pcg::new(3);
        let mut draw = || f64::from(r.draw());
        let lights: Vec<TreeLight> = (0..200)
            .map(|_| {
                let p = DVec3::new(draw(), draw(), draw()) * 10.0;
                let axis = (DVec3::new(draw(), draw(), draw()) - 0.5).normalize();
                TreeLight { bounds: Bounds::from_corners(p, p + 0.1), axis, spread_rad: 0.0, reach_rad: 0.5 * PI, energy: draw() }
            })
            .collect();
        let tree = LightTree::new(&lights);
        let (p, n) = (DVec3::new(12.0, 3.0, 5.0), Some(DVec3::NEG_X));
        let sum: f64 = (0..200).map(|k| tree.chance(k, p, n)).sum();
        // What is missing to 1 are groups of which no member shines this way: they draw nothing.
        let (mut drawn, total) = (0, 20_000);
        for k in 0..total {
            let Some((light, chance)) = tree.sample(p, n, (f64::from(k) + 0.5) / f64::from(total)) else { continue };
            drawn += 1;
            assert!((tree.chance(light, p, n) - chance).abs() < 1e-12 && chance > 0.0);
        }
        assert!((sum - f64::from(drawn) / f64::from(total)).abs() < 1e-2 && sum > 0.8, "{sum} {drawn}");
    }
}
