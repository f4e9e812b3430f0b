//! Clip and inside programs: CSG as lists of steps that `kernel/inside` runs. See `geometry::InsideStep`.

use super::geometry::InsideStep;
use crate::math::Bounds;
use std::ops::Range;

/// What a node of an object's tree does once inversions are pushed down to the leaves.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NodeKind {
    /// A primitive.
    Leaf(u32),
    /// Inside all children.
    All(Vec<usize>),
    /// Inside any child; surfaces stay.
    Any(Vec<usize>),
    /// Inside any child; surfaces inside other children go.
    Merge(Vec<usize>),
}

/// A node of one top-level object's tree.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub kind: NodeKind,
    /// All of these must hold too.
    pub clips: Vec<usize>,
    /// Holds the points inside.
    pub bounds: Bounds,
    /// Holds the points outside.
    pub cobounds: Bounds,
    /// Holds the surface.
    pub surface_bounds: Bounds,
    /// Primitives below, those of clip objects included.
    pub prims: Range<u32>,
    /// A ray that misses this box misses a leaf that is an object by itself; of one in a CSG the surface beyond is left out.
    /// Of a set that is an object by itself only parts without an end are cut by it, as its bounds are asked exactly.
    pub cull_box: Option<Bounds>,
    /// Some of it has an inside.
    pub solid: bool,
    /// Its `bounded_by` must be asked exactly, not by its box alone.
    pub keeps_bounds: bool,
    /// Only the first child counts for cutaway textures.
    pub is_difference: bool,
}

impl Node {
    /// A node that nothing clips or bounds yet: `[bounds, cobounds]` hold its inside and its outside.
    pub fn new(kind: NodeKind, [bounds, cobounds]: [Bounds; 2], surface_bounds: Bounds, solid: bool) -> Self {
        Self {
            kind,
            clips: Vec::new(),
            bounds,
            cobounds,
            surface_bounds,
            cull_box: None,
            prims: 0..0,
            solid,
            is_difference: false,
            keeps_bounds: false,
        }
    }
}

/// Most children that are asked one by one, without a box around some of them. Picked by feel.
const GROUP: usize = 8;

/// Writes steps for the nodes of one object.
pub(super) struct ProgramWriter<'a> {
    pub nodes: &'a [Node],
    pub boxes: &'a mut Vec<Bounds>,
}

impl ProgramWriter<'_> {
    /// Steps that make the program false unless "inside `node`" is `want`.
    pub fn require(&mut self, node: usize, want: bool, out: &mut Vec<InsideStep>) {
        let nodes = self.nodes;
        let n = &nodes[node];
        match (&n.kind, want) {
            (NodeKind::Leaf(p), true) => {
                out.push(InsideStep::RequireIn(*p));
                n.clips.iter().for_each(|c| self.require(*c, true, out));
            }
            (NodeKind::Leaf(p), false) if n.clips.is_empty() => out.push(InsideStep::RequireOut(*p)),
            (NodeKind::All(children), true) => {
                self.require_each(children, true, false, out);
                n.clips.iter().for_each(|c| self.require(*c, true, out));
            }
            (NodeKind::Any(children) | NodeKind::Merge(children), false) if n.clips.is_empty() => {
                self.require_each(children, false, false, out);
            }
            _ => {
                let holds = if want { &n.cobounds } else { &n.bounds };
                self.guarded(holds, 2, out, |w, out| {
                    w.value(node, out);
                    if !want {
                        out.push(InsideStep::Not);
                    }
                    out.push(InsideStep::Require);
                });
            }
        }
    }

    /// Steps that push "inside `node`".
    pub fn value(&mut self, node: usize, out: &mut Vec<InsideStep>) {
        let nodes = self.nodes;
        let n = &nodes[node];
        match &n.kind {
            NodeKind::Leaf(p) => out.push(InsideStep::Prim(*p)),
            NodeKind::All(children) => {
                for (k, c) in children.iter().enumerate() {
                    self.value(*c, out);
                    if k > 0 {
                        out.push(InsideStep::And);
                    }
                }
            }
            NodeKind::Any(children) | NodeKind::Merge(children) => self.any_value(children, out),
        }
        for c in &n.clips {
            self.value(*c, out);
            out.push(InsideStep::And);
        }
    }

    /// Steps that push "inside any of `children`". Where a box test says that a point is in none of a part, the part is not gone into.
    fn any_value(&mut self, children: &[usize], out: &mut Vec<InsideStep>) {
        let parts = neighbours(children, |c| self.nodes[c].bounds);
        for (k, part) in parts.iter().enumerate() {
            let holds = part.iter().fold(Bounds::EMPTY, |b, c| b.union(self.nodes[*c].bounds));
            let costs_more_than_a_box = part.len() > 1 || !matches!(self.nodes[part[0]].kind, NodeKind::Leaf(_));
            let at = out.len();
            let guard = costs_more_than_a_box && !holds.is_unbounded();
            if guard {
                out.push(InsideStep::Not); // replaced below
            }
            match part.as_slice() {
                [one] => self.value(*one, out),
                part => self.any_value(part, out),
            }
            if guard {
                out[at] = InsideStep::FalseOutside { box_ix: self.box_ix(holds), skip: (out.len() - at - 1) as u32 };
            }
            if k > 0 {
                out.push(InsideStep::Or);
            }
        }
    }

    /// What a hit on something below `node` must satisfy because of `node` itself.
    pub fn conditions(&mut self, node: usize, out: &mut Vec<InsideStep>) {
        let nodes = self.nodes;
        let n = &nodes[node];
        let (children, want) = match &n.kind {
            NodeKind::All(c) => (c.as_slice(), true),
            NodeKind::Merge(c) => (c.as_slice(), false),
            _ => (&[][..], true),
        };
        if children.len() > 1 {
            self.require_each(children, want, true, out);
        }
        n.clips.iter().for_each(|c| self.require(*c, true, out));
    }

    /// Steps for all of `children`; with `but_own` a hit's own child is left out. Many children are guarded in groups.
    fn require_each(&mut self, children: &[usize], want: bool, but_own: bool, out: &mut Vec<InsideStep>) {
        let nodes = self.nodes;
        let holds = children.iter().fold(Bounds::EMPTY, |b, c| b.union(if want { nodes[*c].cobounds } else { nodes[*c].bounds }));
        self.guarded(&holds, children.len(), out, |w, out| {
            if children.len() > GROUP {
                let parts = neighbours(children, |c| if want { nodes[c].cobounds } else { nodes[c].bounds });
                return parts.iter().for_each(|part| w.require_each(part, want, but_own, out));
            }
            for c in children {
                let p = &nodes[*c].prims;
                let at = out.len();
                if but_own {
                    out.push(InsideStep::Not); // replaced below
                }
                w.require(*c, want, out);
                if but_own {
                    out[at] = InsideStep::SkipOwn { first: p.start, count: p.end - p.start, skip: (out.len() - at - 1) as u32 };
                }
            }
        });
    }

    /// Puts a box test before steps that cannot fail outside `holds`, where that is finite and worth it.
    fn guarded(&mut self, holds: &Bounds, n_parts: usize, out: &mut Vec<InsideStep>, f: impl FnOnce(&mut Self, &mut Vec<InsideStep>)) {
        let at = out.len();
        let guard = n_parts > 1 && !holds.is_unbounded();
        if guard {
            out.push(InsideStep::Not); // replaced below
        }
        f(self, out);
        if guard {
            out[at] = InsideStep::SkipOutside { box_ix: self.box_ix(*holds), skip: (out.len() - at - 1) as u32 };
        }
    }

    /// The place of a box among those that points are tested against.
    fn box_ix(&mut self, b: Bounds) -> u32 {
        self.boxes.push(b);
        self.boxes.len() as u32 - 1
    }
}

/// Children in parts whose boxes lie apart as far as may be: each by itself where they are few, else those without a box by groups of
/// [`GROUP`], then the two halves of the rest along the axis that their middles are farthest apart on. Each part is smaller than the whole.
fn neighbours(children: &[usize], bounds: impl Fn(usize) -> Bounds) -> Vec<Vec<usize>> {
    if children.len() <= GROUP {
        return children.iter().map(|c| vec![*c]).collect();
    }
    let (open, mut closed): (Vec<usize>, Vec<usize>) = children.iter().partition(|c| bounds(**c).is_unbounded() || bounds(**c).is_empty());
    let mut parts: Vec<Vec<usize>> = open.chunks(GROUP).map(<[usize]>::to_vec).collect();
    let middles = closed.iter().fold(Bounds::EMPTY, |b, c| b.including(bounds(*c).center()));
    let axis = middles.size().max_position();
    closed.sort_by(|a, b| bounds(*a).center()[axis].total_cmp(&bounds(*b).center()[axis]));
    let (low, high) = closed.split_at(closed.len() / 2);
    parts.extend([low, high].into_iter().filter(|half| !half.is_empty()).map(<[usize]>::to_vec));
    parts
}

/// Deepest stack that `steps` need.
pub(super) fn stack_depth(steps: &[InsideStep]) -> usize {
    let (mut now, mut deepest) = (0usize, 0);
    for s in steps {
        match s {
            InsideStep::Prim(_) => now += 1,
            InsideStep::And | InsideStep::Or | InsideStep::Require => now -= 1,
            _ => {}
        }
        deepest = deepest.max(now);
    }
    deepest
}
