//! Where renderers break, measured: 24 cases, each a figure against its bar, on the CPU and on every GPU. `rayloom bench stability`.
//! The cases are those that FACTS of the field name: leaks, far and tiny scenes, grazing roots, coincident faces, numbers that are none.

mod figures;
pub mod leaks;
pub mod meshes;
pub mod oracle;
mod peers;
mod pictures;
pub mod ray_source;
mod roots;
mod solids;
mod surfaces;
mod trees;

pub use figures::{Effort, Figure, Report};
pub use peers::Peers;

/// A case of the table.
pub struct Case {
    /// As in docs/stability.md.
    pub number: u32,
    /// What is tried.
    pub name: &'static str,
    run: fn(&mut Report),
}

/// All cases.
pub const CASES: [Case; 24] = [
    Case { number: 1, name: "closed meshes, random rays from inside", run: leaks::random },
    Case { number: 2, name: "the same, aimed at vertices and edges", run: leaks::aimed },
    Case { number: 3, name: "the same, far away, tiny and huge", run: leaks::moved },
    Case { number: 4, name: "trees against brute force, 20 meshes", run: trees::against_brute_force },
    Case { number: 5, name: "CPU against GPU, same rays", run: trees::against_gpu },
    Case { number: 6, name: "rays along axes and in planes of the tree", run: trees::along_axes },
    Case { number: 7, name: "rays in the plane of a flat scene", run: trees::flat },
    Case { number: 8, name: "rays that are NaN, infinite or empty", run: trees::no_rays },
    Case { number: 9, name: "garbage geometry", run: trees::garbage },
    Case { number: 10, name: "self-intersection, radii 1e-8 to 1e8", run: surfaces::self_intersection },
    Case { number: 11, name: "contact shadow across a gap of 1e-4", run: surfaces::gap },
    Case { number: 12, name: "scene and camera moved by 1e6", run: pictures::far_away },
    Case { number: 13, name: "sphere seen from 1e2 to 1e7 radii", run: surfaces::far_sphere },
    Case { number: 14, name: "giant sphere as ground", run: surfaces::giant_sphere },
    Case { number: 15, name: "torus from 1 to 1e6 radii away", run: roots::far_torus },
    Case { number: 16, name: "quartics with double, triple and far roots", run: roots::corpus },
    Case { number: 17, name: "cylinders and cones, in and out", run: solids::parity },
    Case { number: 18, name: "CSG with coincident faces", run: solids::coincident },
    Case { number: 19, name: "20 nested dielectrics", run: solids::nested },
    Case { number: 20, name: "needles and slivers", run: trees::needles },
    Case { number: 21, name: "instances against flattened meshes", run: solids::instances },
    Case { number: 22, name: "a scene of 1e-38", run: trees::denormal },
    Case { number: 23, name: "NaN and infinity in light and textures", run: pictures::no_numbers },
    Case { number: 24, name: "white furnace, 64 bounces", run: pictures::furnace },
];

/// Runs the cases with these numbers (all for none); `told` hears of every figure as soon as it is known. `peers` are asked as well where they
/// can answer.
pub fn run(numbers: &[u32], effort: Effort, peers: Peers, told: &mut dyn FnMut(&Figure)) -> Vec<Figure> {
    let mut report = Report::new(effort, peers, told);
    for case in CASES.iter().filter(|c| numbers.is_empty() || numbers.contains(&c.number)) {
        report.case = case.number;
        (case.run)(&mut report);
    }
    report.figures
}
