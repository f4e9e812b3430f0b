//! Structures of `accel/` as words that the traversals of `shaders/accel/` read, and which shader walks them.

use super::shader::ShaderOptions;
use crate::accel::{Accel, AccelKind, AccelOptions, BVH_LEAF, GRID_LEVELS, Grid, PrimSet, SHORT_STACK, SKIP_COUNT_BITS};

/// A tree, grid or list, relative to wherever it is put.
#[derive(Clone, Debug, Default)]
pub(super) struct TreeWords {
    /// Elements of two words (`kd`, grids) or four; links count elements or nodes from the tree's first.
    pub nodes: Vec<u32>,
    /// What leaves refer to: places in `order` for a kd-tree, else nothing but a grid's lists.
    pub refs: Vec<u32>,
    /// Primitives in the order that leaves count them by.
    pub order: Vec<u32>,
    /// Entries of the stack.
    pub depth: u32,
}

/// The structure of kind `kind` over `prims`: `built` if it is one, else a new one.
pub(super) fn structure_of(kind: AccelKind, built: &Accel, prims: &impl PrimSet) -> TreeWords {
    let wanted = match kind {
        AccelKind::BruteTiled | AccelKind::BruteGroup => AccelKind::Brute,
        // What the CPU's wide instructions want is no gain here.
        AccelKind::Bvh8 => AccelKind::Bvh,
        kind => kind,
    };
    let same_tree = |a: AccelKind, b: AccelKind| a == b || (is_kd(a) && is_kd(b));
    if same_tree(built.kind(), wanted) {
        return tree_words(built);
    }
    tree_words(&Accel::build(wanted, prims, &AccelOptions::default()))
}

fn is_kd(kind: AccelKind) -> bool {
    matches!(kind, AccelKind::Kd | AccelKind::KdShort | AccelKind::KdRestart)
}

fn tree_words(tree: &Accel) -> TreeWords {
    match tree {
        Accel::Brute(n) => TreeWords { order: (0..*n).collect(), ..TreeWords::default() },
        Accel::Bvh(t) => {
            let child = |child: u32, count: u32| if child & BVH_LEAF == 0 { child } else { child | count << 27 };
            let node = |n: &crate::accel::BvhNode| {
                let mut w = [0; 16];
                let planes = n.planes.iter().flatten().flatten();
                w.iter_mut().zip(planes).for_each(|(w, v)| *w = v.to_bits());
                (w[12], w[13]) = (child(n.child[0], n.count[0]), child(n.child[1], n.count[1]));
                w
            };
            TreeWords {
                nodes: t.nodes.iter().flat_map(node).collect(),
                refs: Vec::new(),
                order: t.refs.clone(),
                depth: t.stats.depth as u32 + 1,
            }
        }
        Accel::BvhSkip(t) => {
            let n_nodes = t.nodes.len() as u32;
            let node = |n: &crate::accel::SkipNode| {
                let [lo, hi] = [n.lo, n.hi].map(|v| v.map(f32::to_bits));
                // The walk's end is marked: the shader does not know the number of nodes.
                let skip = n.skip | u32::from(n.skip >= n_nodes) << 31;
                const { assert!(SKIP_COUNT_BITS == 4) };
                [lo[0], lo[1], lo[2], skip, hi[0], hi[1], hi[2], n.leaf]
            };
            TreeWords { nodes: t.nodes.iter().flat_map(node).collect(), refs: Vec::new(), order: t.refs.clone(), depth: 1 }
        }
        Accel::Wide(t) => {
            let nodes = bytemuck::cast_slice(&t.nodes).to_vec();
            TreeWords { nodes, refs: Vec::new(), order: t.refs.clone(), depth: t.stats.depth as u32 + 1 }
        }
        Accel::Kd(t) => {
            // Primitives in the order in which leaves first name them: what is near in space is near in memory.
            let mut place = vec![u32::MAX; t.stats.n_prims];
            let mut order = Vec::new();
            for r in &t.refs {
                if place[*r as usize] == u32::MAX {
                    place[*r as usize] = order.len() as u32;
                    order.push(*r);
                }
            }
            let refs = t.refs.iter().map(|r| place[*r as usize]).collect();
            let nodes = t.nodes.iter().flat_map(|n| [n.split_or_first, n.meta]).collect();
            TreeWords { nodes, refs, order, depth: t.stats.depth as u32 + 1 }
        }
        Accel::Grid(t) => grid_words(t),
        Accel::Bvh8(_) => unreachable!("`structure_of` asks for a BVH of two children instead"),
    }
}

fn grid_words(t: &Grid) -> TreeWords {
    // As the cells come along x, y and z.
    let mut place = vec![u32::MAX; t.stats.n_prims];
    let mut order = Vec::new();
    for e in t.lists.iter().map(|k| &t.entries[*k as usize]) {
        if place[e.prim as usize] == u32::MAX {
            place[e.prim as usize] = order.len() as u32;
            order.push(e.prim);
        }
    }
    let first_cell = 6 * t.grids.len() as u32;
    let first_entry = first_cell + t.cells.len() as u32;
    let mut nodes = Vec::with_capacity(2 * (first_entry as usize + 2 * t.entries.len()));
    for g in &t.grids {
        let inverse = g.size.map(|s| 1.0 / s);
        nodes.extend(g.lo.iter().chain(&g.size).map(|v| v.to_bits()));
        nodes.extend([crate::accel::pack_cell(g.n.map(|n| n - 1)), first_cell + g.first_cell]);
        nodes.extend(inverse.map(f32::to_bits));
        nodes.push(first_entry);
    }
    nodes.extend(t.cells.iter().flat_map(|c| [c.first, c.count]));
    nodes.extend(t.entries.iter().flat_map(|e| [place[e.prim as usize], e.lo, e.hi, 0]));
    TreeWords { nodes, refs: t.lists.clone(), order, depth: 1 }
}

/// Words of an element of `TreeWords::nodes`.
pub(super) fn words_per_element(kind: AccelKind) -> u32 {
    match kind {
        AccelKind::Bvh | AccelKind::Bvh8 | AccelKind::BvhSkip | AccelKind::Wide => 4,
        _ => 2,
    }
}

/// Whether scenes' references stand before the lists: grids read both.
pub(super) fn has_lists(kind: AccelKind) -> bool {
    matches!(kind, AccelKind::Grid | AccelKind::HierarchicalGrid)
}

/// Tells the shaders how to walk structures of kind `kind`.
pub(super) fn choose_walk(o: &mut ShaderOptions, kind: AccelKind, scene_depth: u32, mesh_depth: u32) {
    o.accel = kind.structure().map_or("brute", |s| s.shader);
    // Its walk takes what has no bounds with it.
    o.feature_if("prelude_scene", o.accel == "bvh" && o.features.contains("unbounded"));
    o.feature_if("node_pairs", words_per_element(kind) == 2);
    o.feature_if("leaf_refs", is_kd(kind));
    o.feature_if("short_stack", kind == AccelKind::KdShort);
    o.feature_if("brute_group", kind == AccelKind::BruteGroup);
    o.feature_if("brute_tiled", kind == AccelKind::BruteTiled);
    o.constant("STACK_scene", scene_depth.max(1));
    o.constant("STACK_mesh", mesh_depth.max(1));
    o.constant("SHORT_STACK", SHORT_STACK as u32);
    o.constant("MAX_GRIDS", if kind == AccelKind::Grid { 1 } else { GRID_LEVELS as u32 });
}
