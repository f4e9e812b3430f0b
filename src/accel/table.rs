//! The one list of acceleration structures: name, what it is, and its traversal on the GPU. Command line, bench and tests read it.

/// Which structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum AccelKind {
    /// A BVH on the CPU, but for a single primitive: that of eight children where the processor has AVX2, else that of two. On a GPU what
    /// its table of choices says (`backend/gpu/choice.rs`).
    ///
    /// One Zen 5 core, Mrays/s primary / shadow / diffuse, an older run: kitchen of 1.4 M faces 11.1 / 22.4 / 6.7 against 9.6 / 14.0 / 5.0 of
    /// the BVH of two and 6.6 / 12.0 / 4.2 of the kd-tree; shells of 311 k 1.02 / 2.9 / 0.63 against 0.75 / 1.8 / 0.42.
    #[default]
    Auto,
    /// Every primitive for every ray; on a GPU each thread has its own ray and reads from global memory.
    Brute,
    /// Every primitive for every ray; on a GPU a workgroup brings primitives into its own memory, tile by tile.
    BruteTiled,
    /// Every primitive for every ray; on a GPU the threads of a workgroup share the primitives for one ray and keep the nearest.
    BruteGroup,
    /// Uniform grid.
    Grid,
    /// Grid whose full cells are grids.
    HierarchicalGrid,
    /// Bounding volume hierarchy, nodes of two boxes, with a stack.
    Bvh,
    /// Bounding volume hierarchy in one order, with links to what follows a miss; no stack.
    BvhSkip,
    /// Bounding volume hierarchy of eight children with boxes of a byte a side.
    Wide,
    /// Bounding volume hierarchy of eight children for the CPU's wide instructions; on a GPU that of two.
    Bvh8,
    /// kd-tree with a whole stack.
    Kd,
    /// kd-tree with a stack of eight, from the root again when that runs dry.
    KdShort,
    /// kd-tree without a stack, from the root again after each leaf.
    KdRestart,
}

/// What there is to say about a structure.
#[derive(Clone, Copy, Debug)]
pub struct Structure {
    /// Which.
    pub kind: AccelKind,
    /// On the command line and in tables.
    pub name: &'static str,
    /// In one line.
    pub summary: &'static str,
    /// Module of its traversal in `shaders/accel/`.
    pub shader: &'static str,
}

const fn structure(kind: AccelKind, name: &'static str, shader: &'static str, summary: &'static str) -> Structure {
    Structure { kind, name, summary, shader }
}

/// All structures.
pub const STRUCTURES: [Structure; 12] = [
    structure(AccelKind::Brute, "brute", "brute", "every primitive for every ray"),
    structure(AccelKind::BruteTiled, "brute-tiled", "brute", "the same, primitives staged in workgroup memory"),
    structure(AccelKind::BruteGroup, "brute-group", "brute", "the same, one ray a workgroup"),
    structure(AccelKind::Grid, "grid", "grid", "uniform grid, 3D-DDA"),
    structure(AccelKind::HierarchicalGrid, "hgrid", "grid", "grid whose full cells are grids"),
    structure(AccelKind::Bvh, "bvh", "bvh", "BVH, nodes of two boxes, a stack"),
    structure(AccelKind::BvhSkip, "bvh-skip", "bvh_skip", "BVH with skip links, no stack"),
    structure(AccelKind::Wide, "wide", "wide", "BVH of eight children, boxes in bytes"),
    structure(AccelKind::Bvh8, "bvh8", "bvh", "BVH of eight children for the CPU's wide instructions"),
    structure(AccelKind::Kd, "kd", "kd", "kd-tree, a whole stack"),
    structure(AccelKind::KdShort, "kd-short", "kd_trail", "kd-tree, a stack of eight, then restart"),
    structure(AccelKind::KdRestart, "kd-restart", "kd_trail", "kd-tree, restart without a stack"),
];

impl AccelKind {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        self.structure().map_or("auto", |s| s.name)
    }

    /// By its name on the command line.
    pub fn named(name: &str) -> Option<Self> {
        if name == "auto" {
            return Some(Self::Auto);
        }
        STRUCTURES.iter().find(|s| s.name == name).map(|s| s.kind)
    }

    /// What there is to say; nothing of `Auto`.
    pub fn structure(self) -> Option<&'static Structure> {
        STRUCTURES.iter().find(|s| s.kind == self)
    }

    /// Names on the command line, `auto` first.
    pub fn names() -> impl Iterator<Item = &'static str> {
        std::iter::once("auto").chain(STRUCTURES.iter().map(|s| s.name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_back_to_their_kinds() {
        for name in AccelKind::names() {
            assert_eq!(AccelKind::named(name).map(AccelKind::name), Some(name));
        }
        assert_eq!(AccelKind::named("octree"), None);
    }
}
