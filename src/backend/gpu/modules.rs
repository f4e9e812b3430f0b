//! The text of every shader module, embedded. A file in `shaders/` that is not listed here does not exist for the program.

macro_rules! modules {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../../shaders/", $name, ".wesl")))),*]
    };
}

/// Name (path below `shaders/` without extension) and text.
pub const MODULES: &[(&str, &str)] = modules![
    "probes/double",
    "probes/normal",
    "probes/pigment",
    "probes/texture",
    "probes/texture_inputs",
    "shared/angles",
    "shared/function_internal",
    "shared/function_math",
    "shared/image",
    "shared/map",
    "shared/map_colors",
    "shared/noise",
    "shared/normal",
    "shared/pattern",
    "shared/pattern_cells",
    "shared/pattern_density",
    "shared/pattern_fractal",
    "shared/pattern_function",
    "shared/pattern_noisy",
    "shared/pattern_simple",
    "shared/pattern_tiling",
    "shared/pigment",
    "shared/texture",
    "shared/texture_point",
    "shared/warp",
    "shared/words",
];
