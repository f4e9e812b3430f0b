//! What cuts primitives: the clip programs that CSG and `clipped_by` leave, and the boxes of what remains.

use super::super::CompileError;
use super::super::geometry::{InsideProgram, InsideStep, PrimKind, prim_flags};
use super::super::half_spaces::{HalfSpace, MOST as MAX_HALF_SPACES, shrunk};
use super::super::programs::{NodeKind, ProgramWriter, stack_depth};
use super::Flattener;
use crate::math::Bounds;

/// Most steps of all programs.
const MAX_STEPS: usize = 1 << 26;

impl Flattener {
    pub(super) fn writer(&mut self) -> ProgramWriter<'_> {
        ProgramWriter { nodes: &self.nodes, boxes: &mut self.geometry.clip_boxes }
    }

    pub(super) fn add_program(&mut self, steps: &[InsideStep]) -> Result<InsideProgram, CompileError> {
        let depth = stack_depth(steps);
        if depth > InsideProgram::MAX_DEPTH {
            return Err(CompileError::TooDeep { depth, limit: InsideProgram::MAX_DEPTH });
        }
        let start = self.geometry.clip_steps.len();
        if start + steps.len() > MAX_STEPS {
            let count = (start + steps.len()) as u64;
            return Err(CompileError::TooMany { what: "steps of CSG programs", count, limit: MAX_STEPS as u64 });
        }
        self.charge(2 * size_of_val(steps))?;
        self.geometry.clip_steps.extend_from_slice(steps);
        Ok(InsideProgram { start: start as u32, len: steps.len() as u32 })
    }

    /// Adds the leaves whose covers cut surfaces may show: of differences only the first child's.
    pub(super) fn cutaway_parts(&mut self, node: usize) -> Result<(), CompileError> {
        match self.nodes[node].kind.clone() {
            NodeKind::Leaf(p) => {
                let mut steps = Vec::new();
                self.writer().require(node, true, &mut steps);
                let program = self.add_program(&steps)?;
                self.geometry.cutaway_parts.push((program, self.geometry.prims[p as usize].surface_ix));
                Ok(())
            }
            NodeKind::All(list) | NodeKind::Any(list) | NodeKind::Merge(list) => {
                let n = if self.nodes[node].is_difference { 1 } else { list.len() };
                list.iter().take(n).try_for_each(|c| self.cutaway_parts(*c))
            }
        }
    }

    /// The half-space that a node is, if it is a plane.
    fn half_space(&self, node: usize) -> Option<HalfSpace> {
        let NodeKind::Leaf(prim_ix) = self.nodes[node].kind else { return None };
        let prim = &self.geometry.prims[prim_ix as usize];
        let plane = (prim.kind == PrimKind::Plane).then(|| &self.leaves.shapes.planes[prim.shape_ix as usize])?;
        let below = HalfSpace { normal: plane.normal, limit: plane.distance };
        Some(if prim.flags & prim_flags::INVERTED != 0 { below.flipped() } else { below })
    }

    /// Gives the leaves below `node` their clip programs and bounds. `program` is `steps` as already added; `within` are half-spaces that
    /// hold what is left of them, beside `cut`.
    pub(super) fn assign(
        &mut self,
        node: usize,
        steps: &[InsideStep],
        program: InsideProgram,
        cut: Bounds,
        within: &mut Vec<HalfSpace>,
    ) -> Result<(), CompileError> {
        let n = self.nodes[node].clone();
        let n_above = within.len();
        within.extend(n.clips.iter().filter_map(|c| self.half_space(*c)));
        let cut = cut.intersection(n.surface_bounds);
        let mut own = Vec::new();
        self.writer().conditions(node, &mut own);
        let (mut steps, mut program) = (steps, program);
        if !own.is_empty() {
            own.extend_from_slice(steps);
            program = self.add_program(&own)?;
            steps = &own;
        }
        let list = match &n.kind {
            NodeKind::Leaf(p) => {
                let prim = &mut self.geometry.prims[*p as usize];
                (prim.clip_start, prim.clip_len) = (program.start, program.len);
                let own = self.half_space(node);
                within.extend(own.into_iter().flat_map(|h| [h, h.flipped()]));
                self.geometry.bounds[*p as usize] = shrunk(cut, within);
                within.truncate(n_above);
                return Ok(());
            }
            NodeKind::All(list) | NodeKind::Any(list) | NodeKind::Merge(list) => list,
        };
        let is_all = matches!(n.kind, NodeKind::All(_));
        // Boxes of all children but one, from both ends, so that many children stay cheap.
        let after: Vec<Bounds> = list
            .iter()
            .rev()
            .scan(Bounds::UNBOUNDED, |b, c| {
                let now = *b;
                *b = b.intersection(self.nodes[*c].bounds);
                Some(now)
            })
            .collect();
        let planes: Vec<(usize, HalfSpace)> = match is_all {
            true => list.iter().filter_map(|c| Some((*c, self.half_space(*c)?))).take(MAX_HALF_SPACES + 1).collect(),
            false => Vec::new(),
        };
        let mut before = cut;
        for (k, c) in list.iter().enumerate() {
            let child_cut = if is_all { before.intersection(after[list.len() - 1 - k]) } else { cut };
            let n_here = within.len();
            within.extend(planes.iter().filter(|(plane, _)| plane != c).map(|(_, h)| *h));
            self.assign(*c, steps, program, child_cut, within)?;
            within.truncate(n_here);
            before = before.intersection(self.nodes[*c].bounds);
        }
        within.truncate(n_above);
        Ok(())
    }
}
