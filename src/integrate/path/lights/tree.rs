//! A tree over lamps and shining triangles: one is drawn with a chance near its share of the light that arrives.
//!
//! Source: Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting" (without the splitting).

use crate::math::simd::{self, Kernel, Simd};
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
    /// Of the cone; -1 for all directions, which 32 bits tell to the bit.
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

/// The tree. The nodes are what the GPU reads; the CPU walks twigs, two levels of nodes in one step.
#[derive(Clone, Debug, Default)]
pub struct LightTree {
    nodes: Vec<Node>,
    /// Leaf of each light.
    leaves: Vec<u32>,
    /// Of the root, then of grandchildren that are no leaves; none where a light is alone.
    twigs: Vec<Twig>,
    /// Where each light is in its twig.
    seats: Vec<Seat>,
}

/// Children and grandchildren of a node. A child that is a leaf stands as its own first child, beside one without light.
#[derive(Clone, Copy, Debug)]
struct Twig {
    lanes: NodeLanes,
    /// Of the four grandchildren: a place in the twigs, or a light with [`Twig::LIGHT`].
    below: [u32; 4],
    /// The node that the twig is of; none for the root.
    seat: Option<Seat>,
}

impl Twig {
    const LIGHT: u32 = 1 << 31;
}

/// A node as a grandchild, 0 to 3, in a twig.
#[derive(Clone, Copy, Debug)]
struct Seat {
    twig: u32,
    place: u32,
}

/// Never none: what bounds miss (bent normals) must stay possible.
const LEAST_COS: f32 = 0.03;

impl LightTree {
    /// Over `lights`.
    pub fn new(lights: &[TreeLight]) -> Self {
        let mut tree = Self { nodes: Vec::with_capacity(2 * lights.len()), leaves: vec![u32::MAX; lights.len()], ..Self::default() };
        let mut order: Vec<u32> = (0..lights.len() as u32).collect();
        if !order.is_empty() {
            tree.build(lights, &mut order, u32::MAX);
        }
        if lights.len() > 1 {
            tree.seats = vec![Seat { twig: 0, place: 0 }; lights.len()];
            tree.grow(0, None);
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

    /// Makes the twig of a node that is no leaf, and those below it.
    fn grow(&mut self, node: usize, seat: Option<Seat>) {
        let at = self.twigs.len() as u32;
        let children = [node + 1, self.nodes[node].right as usize];
        let grand = children.map(|c| match self.nodes[c].right {
            u32::MAX => [(c, true), (c, false)],
            right => [(c + 1, true), (right as usize, true)],
        });
        let mut lanes = NodeLanes::default();
        let lit = children.map(|c| (c, true)).into_iter().chain(grand.into_iter().flatten());
        for (l, (k, shines)) in lit.enumerate() {
            lanes.set(l, &self.nodes[k], &self.nodes[0], shines);
        }
        self.twigs.push(Twig { lanes, below: [0; 4], seat });
        for (place, (k, shines)) in (0u32..).zip(grand.into_iter().flatten()) {
            let seat = Seat { twig: at, place };
            let Node { right, light, .. } = self.nodes[k];
            self.twigs[at as usize].below[place as usize] = if right == u32::MAX { light | Twig::LIGHT } else { self.twigs.len() as u32 };
            if right != u32::MAX {
                self.grow(k, Some(seat));
            } else if shines {
                self.seats[light as usize] = seat;
            }
        }
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

    /// About the irradiance at `p` on a surface with normal `n` (none in volumes) from all lights: of the nodes four levels down.
    pub fn estimate(&self, p: DVec3, n: Option<DVec3>) -> f64 {
        let Some(root) = self.nodes.first() else { return 0.0 };
        if self.twigs.is_empty() {
            let mut alone = NodeLanes::default();
            alone.set(0, root, root, true);
            return root.energy * f64::from(simd::run(Weights { lanes: &alone, at: Place::new(root.center, p, n) })[0]);
        }
        root.energy * simd::run(Estimate { tree: self, at: Place::new(root.center, p, n) })
    }

    /// Draws a light for `p` and `n` with `u`; gives it with its chance. `None`: none shines this way.
    pub fn sample(&self, p: DVec3, n: Option<DVec3>, u: f64) -> Option<(u32, f64)> {
        let root = self.nodes.first()?;
        if self.twigs.is_empty() {
            return Some((root.light, 1.0));
        }
        simd::run(Draw { tree: self, at: Place::new(root.center, p, n), u })
    }

    /// Chance with which [`Self::sample`] draws `light`.
    pub fn chance(&self, light: u32, p: DVec3, n: Option<DVec3>) -> f64 {
        match (self.seats.get(light as usize), self.nodes.first()) {
            (Some(seat), Some(root)) => simd::run(ChanceOf { tree: self, seat: *seat, at: Place::new(root.center, p, n) }),
            _ => 1.0,
        }
    }
}

/// Where light is asked for.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// From the middle of all lights.
    p: [f32; 3],
    n: Option<[f32; 3]>,
}

impl Place {
    fn new(middle: DVec3, p: DVec3, n: Option<DVec3>) -> Self {
        Self { p: (p - middle).as_vec3().to_array(), n: n.map(|n| n.as_vec3().to_array()) }
    }
}

/// Importances of a twig: children 0 and 1, grandchildren 2 to 5.
type Importances = [f32; 8];

/// Chance of the first of two; `None` where neither shines this way.
#[inline(always)]
fn chance_of_first(w: &Importances, first: usize) -> Option<f64> {
    let (a, b) = (f64::from(w[first]), f64::from(w[first + 1]));
    let sum = a + b;
    if sum > 0.0 { Some(a / sum) } else { None }
}

/// See [`LightTree::sample`].
struct Draw<'t> {
    tree: &'t LightTree,
    at: Place,
    u: f64,
}

impl Kernel for Draw<'_> {
    type Output = Option<(u32, f64)>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let (mut twig, mut chance, mut u) = (0, 1.0, self.u);
        loop {
            let Twig { lanes, below, .. } = &self.tree.twigs[twig as usize];
            let w = lanes.importances(simd, &self.at);
            let mut place = 0;
            for level in 0..2 {
                let first = chance_of_first(&w, if level == 0 { 0 } else { 2 + 2 * place })?;
                let second = u >= first;
                if second {
                    u = ((u - first) / (1.0 - first)).min(1.0 - 1e-12);
                    chance *= 1.0 - first;
                } else {
                    u /= first;
                    chance *= first;
                }
                place = 2 * place + usize::from(second);
            }
            twig = below[place];
            if twig & Twig::LIGHT != 0 {
                return Some((twig & !Twig::LIGHT, chance));
            }
        }
    }
}

/// See [`LightTree::chance`].
struct ChanceOf<'t> {
    tree: &'t LightTree,
    seat: Seat,
    at: Place,
}

impl Kernel for ChanceOf<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> f64 {
        let (mut seat, mut chance) = (self.seat, 1.0);
        loop {
            let twig = &self.tree.twigs[seat.twig as usize];
            let w = twig.lanes.importances(simd, &self.at);
            let child = seat.place as usize / 2;
            for (first, second) in [(2 + 2 * child, seat.place % 2 == 1), (0, child == 1)] {
                let Some(first) = chance_of_first(&w, first) else { return 0.0 };
                chance *= if second { 1.0 - first } else { first };
            }
            match twig.seat {
                Some(above) => seat = above,
                None => return chance,
            }
        }
    }
}

/// See [`LightTree::estimate`].
struct Estimate<'t> {
    tree: &'t LightTree,
    at: Place,
}

impl Kernel for Estimate<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> f64 {
        let root = &self.tree.twigs[0];
        let w = root.lanes.importances(simd, &self.at);
        let mut sum = 0.0;
        for k in 0..4 {
            if root.below[k] & Twig::LIGHT != 0 {
                sum += f64::from(w[2 + k]);
            } else {
                let w = self.tree.twigs[root.below[k] as usize].lanes.importances(simd, &self.at);
                sum += f64::from(w[2]) + f64::from(w[3]) + f64::from(w[4]) + f64::from(w[5]);
            }
        }
        sum
    }
}

/// Importances by themselves.
struct Weights<'l> {
    lanes: &'l NodeLanes,
    at: Place,
}

impl Kernel for Weights<'_> {
    type Output = Importances;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Importances {
        self.lanes.importances(simd, &self.at)
    }
}

/// Eight nodes, number by number; those that are none have no energy. In 32 bits, as on the GPU: a chance need not be exact, but the same wherever it is asked for.
#[derive(Clone, Copy, Debug, Default)]
struct NodeLanes {
    /// From the middle of all lights.
    center: [[f32; 8]; 3],
    radius_sq: [f32; 8],
    axis: [[f32; 8]; 3],
    cos_spread: [f32; 8],
    sin_spread: [f32; 8],
    cos_reach: [f32; 8],
    /// Of all lights' energy.
    energy: [f32; 8],
}

impl NodeLanes {
    /// Lane `l`: node `n` of the tree with this root, or, where it does not shine, its place without its light.
    fn set(&mut self, l: usize, n: &Node, root: &Node, shines: bool) {
        let (center, axis) = ((n.center - root.center).as_vec3(), n.axis.as_vec3());
        for k in 0..3 {
            (self.center[k][l], self.axis[k][l]) = (center[k], axis[k]);
        }
        self.radius_sq[l] = (n.radius * n.radius) as f32;
        (self.cos_spread[l], self.sin_spread[l], self.cos_reach[l]) = (n.cos_spread as f32, n.sin_spread as f32, n.cos_reach as f32);
        self.energy[l] = if shines && root.energy > 0.0 { (n.energy / root.energy) as f32 } else { 0.0 };
    }

    /// About the irradiance from all below each node. Lanes that have no use for a number may have NaN there. Without closures, which would not be
    /// compiled for AVX2.
    #[inline(always)]
    fn importances<S: Simd>(&self, s: S, at: &Place) -> Importances {
        let one = s.splat_f32(1.0);
        let [x, y, z] = &self.center;
        let to = [
            s.sub_f32(s.load_f32(x), s.splat_f32(at.p[0])),
            s.sub_f32(s.load_f32(y), s.splat_f32(at.p[1])),
            s.sub_f32(s.load_f32(z), s.splat_f32(at.p[2])),
        ];
        let (d_sq, r_sq, energy) = (dot(s, to, to), s.load_f32(&self.radius_sq), s.load_f32(&self.energy));
        let inv = s.div_f32(one, s.sqrt_f32(d_sq));
        let dir = [s.mul_f32(to[0], inv), s.mul_f32(to[1], inv), s.mul_f32(to[2], inv)];
        let sin_u_sq = s.div_f32(r_sq, d_sq);
        let ball = (s.sqrt_f32(s.sub_f32(one, sin_u_sq)), s.sqrt_f32(sin_u_sq));
        let cone = (s.load_f32(&self.cos_spread), s.load_f32(&self.sin_spread));
        let [x, y, z] = &self.axis;
        let cos = s.sub_f32(s.splat_f32(0.0), dot(s, dir, [s.load_f32(x), s.load_f32(y), s.load_f32(z)]));
        let (leaving, _) = less_angle(s, less_angle(s, (cos, sine(s, cos)), cone), ball);
        let dark = s.le_f32(leaving, s.load_f32(&self.cos_reach));
        let some = s.select_f32(dark, s.splat_f32(0.0), s.max_f32(leaving, s.splat_f32(0.05)));
        let leaving = s.select_f32(s.le_f32(cone.0, s.splat_f32(-1.0)), one, some);
        let arriving = match at.n {
            None => one,
            Some([x, y, z]) => {
                let cos = dot(s, dir, [s.splat_f32(x), s.splat_f32(y), s.splat_f32(z)]);
                s.max_f32(less_angle(s, (cos, sine(s, cos)), ball).0, s.splat_f32(LEAST_COS))
            }
        };
        let outside = s.div_f32(s.mul_f32(s.mul_f32(energy, leaving), arriving), d_sq);
        // Inside the ball every direction is possible.
        let inside = s.div_f32(energy, s.max_f32(r_sq, s.splat_f32(1e-12)));
        s.array_f32(s.select_f32(s.le_f32(d_sq, r_sq), inside, outside))
    }
}

#[inline(always)]
fn dot<S: Simd>(s: S, a: [S::F32x8; 3], b: [S::F32x8; 3]) -> S::F32x8 {
    s.add_f32(s.add_f32(s.mul_f32(a[0], b[0]), s.mul_f32(a[1], b[1])), s.mul_f32(a[2], b[2]))
}

/// Of an angle's cosine.
#[inline(always)]
fn sine<S: Simd>(s: S, cos: S::F32x8) -> S::F32x8 {
    s.sqrt_f32(s.max_f32(s.sub_f32(s.splat_f32(1.0), s.mul_f32(cos, cos)), s.splat_f32(0.0)))
}

/// Cosine and sine of an angle less another, no less than none.
#[inline(always)]
fn less_angle<S: Simd>(s: S, a: (S::F32x8, S::F32x8), b: (S::F32x8, S::F32x8)) -> (S::F32x8, S::F32x8) {
    let none = s.le_f32(b.0, a.0);
    (
        s.select_f32(none, s.splat_f32(1.0), s.add_f32(s.mul_f32(a.0, b.0), s.mul_f32(a.1, b.1))),
        s.select_f32(none, s.splat_f32(0.0), s.sub_f32(s.mul_f32(a.1, b.0), s.mul_f32(a.0, b.1))),
    )
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
