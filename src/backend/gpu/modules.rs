//! The text of every shader module, embedded. A file in `shaders/` that is not listed here does not exist for the program.

macro_rules! modules {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../../shaders/", $name, ".wesl")))),*]
    };
}

/// Name (path below `shaders/` without extension) and text.
pub const MODULES: &[(&str, &str)] = modules![
    "accel/brute",
    "accel/bvh",
    "accel/bvh_skip",
    "accel/grid",
    "accel/kd",
    "accel/kd_trail",
    "accel/wide",
    "area_round",
    "bench/trace_rays",
    "camera_rays",
    "filter_shadow",
    "generate_rays",
    "lens_rays",
    "lens_sums",
    "media_round",
    "path/albedo",
    "path/bindings",
    "path/bounces",
    "path/camera",
    "path/closures",
    "path/corners",
    "path/diffuse",
    "path/emission",
    "path/environment",
    "path/frame",
    "path/fresnel",
    "path/hair",
    "path/hair_lobe",
    "path/inputs",
    "path/lamp",
    "path/light_tree",
    "path/lights",
    "path/lobes",
    "path/microfacet",
    "path/panorama",
    "path/principled",
    "path/scene",
    "path/shading",
    "path/shadow",
    "path/sheen",
    "path/sky",
    "path/sobol",
    "path/step",
    "path/surface",
    "path/thin_film",
    "path/trace_paths",
    "path/transparency",
    "path/triangle",
    "path/volume",
    "path/volume_phase",
    "path/volume_step",
    "path/walk",
    "probes/double",
    "probes/normal",
    "probes/pigment",
    "probes/texture",
    "probes/texture_inputs",
    "project_light",
    "shade",
    "shared/air",
    "shared/algebraic",
    "shared/angles",
    "shared/area",
    "shared/bindings",
    "shared/blob",
    "shared/bounded_by",
    "shared/camera",
    "shared/covers",
    "shared/curve",
    "shared/film",
    "shared/finish",
    "shared/function_internal",
    "shared/function_math",
    "shared/function_registers",
    "shared/function_surfaces",
    "shared/height_field",
    "shared/image",
    "shared/inside",
    "shared/interior_list",
    "shared/intersect",
    "shared/intersect_mesh",
    "shared/isosurface",
    "shared/julia",
    "shared/layer",
    "shared/layout",
    "shared/leaf_mesh",
    "shared/leaf_scene",
    "shared/lens_list",
    "shared/light",
    "shared/light_points",
    "shared/map",
    "shared/map_colors",
    "shared/material",
    "shared/media",
    "shared/noise",
    "shared/normal",
    "shared/outline",
    "shared/pattern",
    "shared/pattern_cells",
    "shared/pattern_density",
    "shared/pattern_fractal",
    "shared/pattern_function",
    "shared/pattern_noisy",
    "shared/pattern_pavement",
    "shared/pattern_penrose",
    "shared/pattern_simple",
    "shared/pattern_tiling",
    "shared/pigment",
    "shared/principled",
    "shared/prism",
    "shared/rainbow",
    "shared/random",
    "shared/real",
    "shared/real_angles",
    "shared/shadow_air",
    "shared/share",
    "shared/slab_ray",
    "shared/solid_mesh",
    "shared/spawn",
    "shared/steps",
    "shared/superellipsoid",
    "shared/surface",
    "shared/texture",
    "shared/texture_point",
    "shared/torus",
    "shared/transform",
    "shared/traverse",
    "shared/tree",
    "shared/turned",
    "shared/unit_roots",
    "shared/warp",
    "shared/words",
    "trace_closest",
    "trace_shadow",
];

#[cfg(test)]
mod tests {
    use super::MODULES;
    use std::collections::HashMap;

    /// Shaders are put together without changing names: two modules of `shared` that have one in common do not compile in a scene that
    /// needs both.
    #[test]
    fn a_name_stands_in_one_shared_module() {
        let mut seen: HashMap<&str, &str> = HashMap::new();
        for (module, text) in MODULES.iter().filter(|(module, _)| module.starts_with("shared/")) {
            for line in text.lines() {
                let line = line.strip_prefix("@if(").and_then(|l| l.split_once(')')).map_or(line, |(_, rest)| rest.trim_start());
                let Some(rest) = ["const ", "fn ", "struct "].iter().find_map(|k| line.strip_prefix(k)) else { continue };
                let name = rest.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or(rest);
                let first = *seen.entry(name).or_insert(module);
                assert_eq!(first, *module, "{name}");
            }
        }
        assert!(seen.len() > 300, "{} names were found", seen.len());
    }
}
