//! Built-in functions as the shaders know them.

use std::collections::BTreeSet;

/// Number, name in WGSL, parameters after the point.
pub(super) type Builtin = (u32, &'static str, usize);

/// Those of `shaders/shared/function_internal.wesl`.
const INTERNAL: &[Builtin] = &[
    (17, "internal_ellipsoid", 3),
    (23, "internal_heart", 1),
    (25, "internal_helix1", 7),
    (29, "internal_hetero_mf", 6),
    (45, "internal_paraboloid", 1),
    (47, "internal_ph", 0),
    (57, "internal_r", 0),
    (58, "internal_ridge", 6),
    (59, "internal_ridged_mf", 6),
    (60, "internal_rounded_box", 4),
    (61, "internal_sphere", 1),
    (63, "internal_spikes_2d", 4),
    (68, "internal_superellipsoid", 2),
    (69, "internal_th", 0),
    (70, "internal_torus", 2),
    (78, "internal_noise", 1),
];

/// Those of `shaders/shared/function_surfaces.wesl`.
const SURFACES: &[Builtin] = &[
    (0, "internal_algbr_cyl1", 5),
    (1, "internal_algbr_cyl2", 5),
    (2, "internal_algbr_cyl3", 5),
    (3, "internal_algbr_cyl4", 5),
    (4, "internal_bicorn", 2),
    (5, "internal_bifolia", 2),
    (6, "internal_blob", 5),
    (7, "internal_blob2", 4),
    (8, "internal_boy_surface", 2),
    (9, "internal_comma", 1),
    (10, "internal_cross_ellipsoids", 4),
    (11, "internal_crossed_trough", 1),
    (12, "internal_cubic_saddle", 1),
    (13, "internal_cushion", 1),
    (14, "internal_devils_curve", 1),
    (15, "internal_devils_curve_2d", 6),
    (16, "internal_dupin_cyclid", 6),
    (18, "internal_enneper", 1),
    (19, "internal_flange_cover", 4),
    (20, "internal_folium_surface", 3),
    (21, "internal_folium_surface_2d", 6),
    (22, "internal_glob", 1),
    (24, "internal_helical_torus", 10),
    (26, "internal_helix2", 6),
    (27, "internal_hex_x", 0),
    (28, "internal_hex_y", 0),
    (30, "internal_hunt_surface", 1),
    (31, "internal_hyperbolic_torus", 3),
    (32, "internal_isect_ellipsoids", 4),
    (33, "internal_kampyle", 3),
    (34, "internal_kampyle_2d", 6),
    (35, "internal_klein_bottle", 1),
    (36, "internal_kummer_v1", 1),
    (37, "internal_kummer_v2", 4),
    (38, "internal_lemniscate", 1),
    (39, "internal_lemniscate_2d", 6),
    (40, "internal_mesh1", 5),
    (41, "internal_mitre", 1),
    (42, "internal_nodal_cubic", 1),
    (43, "internal_cushion", 1),
    (44, "internal_ovals_of_cassini", 4),
    (46, "internal_parabolic_torus", 3),
    (48, "internal_pillow", 1),
    (49, "internal_piriform", 1),
    (50, "internal_piriform_2d", 7),
    (51, "internal_poly4", 5),
    (52, "internal_polytubes", 6),
    (53, "internal_quantum", 0),
    (54, "internal_quartic_paraboloid", 1),
    (55, "internal_quartic_saddle", 1),
    (56, "internal_quartic_cylinder", 3),
    (62, "internal_spikes", 5),
    (64, "internal_spiral", 6),
    (65, "internal_steiners_roman", 1),
    (66, "internal_strophoid", 4),
    (67, "internal_strophoid_2d", 7),
    (71, "internal_torus2", 3),
    (72, "internal_torus_gumdrop", 1),
    (73, "internal_umbrella", 1),
    (74, "internal_witch_of_agnesi", 2),
    (75, "internal_witch_of_agnesi_2d", 6),
];

/// The built-in function of a number.
pub(super) fn builtin(number: u32) -> Option<&'static Builtin> {
    INTERNAL.iter().chain(SURFACES).find(|b| b.0 == number)
}

/// Imports of those that a text calls.
pub(super) fn imports(text: &str) -> String {
    let lines = [("function_internal", INTERNAL), ("function_surfaces", SURFACES)].map(|(module, list)| {
        // Two numbers may name one function.
        let used: BTreeSet<&str> = list.iter().map(|b| b.1).filter(|name| text.contains(&format!("{name}("))).collect();
        let used = Vec::from_iter(used).join(", ");
        if used.is_empty() { used } else { format!("import package::shared::{module}::{{{used}}};\n") }
    });
    lines.concat()
}

#[cfg(test)]
mod tests {
    use super::builtin;
    use crate::compile::function::INTERNAL_NOISE3D;
    use crate::scene::function::internal_args;

    #[test]
    fn every_built_in_function_is_known_and_has_no_more_arguments_than_in_the_language() {
        for (n, n_args) in (0..100).filter_map(|n| Some((n, internal_args(n)?))).filter(|(n, _)| *n != INTERNAL_NOISE3D) {
            let (_, name, n_params) = builtin(n).unwrap_or_else(|| panic!("function {n}"));
            assert!(3 + n_params <= n_args, "{name}: {n_params} after the point, {n_args} in all");
        }
    }
}
