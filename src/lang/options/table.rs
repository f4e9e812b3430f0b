//! The list of options: INI key, switch, what kind of value. What an option does stands in `set`.

/// What a switch takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Takes {
    /// `+X` on, `-X` off; nothing may follow.
    Flag,
    /// A value must follow; `+` and `-` are the same.
    Value,
    /// A value may follow (and then the switch is on); `-X` is off.
    Either,
}

/// One option.
#[derive(Debug)]
pub struct OptionSpec {
    /// INI key, lower case; also `Key=Value` on the command line.
    pub key: &'static str,
    /// Switch letters, upper case, empty for none.
    pub switch: &'static str,
    /// What the switch takes.
    pub takes: Takes,
    /// For options that change nothing here: why. Empty for those that do.
    pub ignored: &'static str,
}

const fn spec(key: &'static str, switch: &'static str, takes: Takes) -> OptionSpec {
    OptionSpec { key, switch, takes, ignored: "" }
}

const fn idle(key: &'static str, switch: &'static str, takes: Takes, ignored: &'static str) -> OptionSpec {
    OptionSpec { key, switch, takes, ignored }
}

pub(super) const WINDOW: &str = "there is no window";
const TREE: &str = "scenes are always put in a tree of our own";
const SHELL: &str = "shell commands are not run, as in Debian's POV-Ray";

use Takes::{Either, Flag, Value};

/// Every option.
pub const OPTIONS: &[OptionSpec] = &[
    spec("width", "W", Value),
    spec("height", "H", Value),
    spec("start_column", "SC", Value),
    spec("end_column", "EC", Value),
    spec("start_row", "SR", Value),
    spec("end_row", "ER", Value),
    spec("antialias", "A", Flag),
    spec("antialias_threshold", "A0", Value),
    spec("sampling_method", "AM", Value),
    spec("antialias_depth", "R", Value),
    spec("antialias_gamma", "AG", Value),
    spec("jitter", "J", Flag),
    spec("jitter_amount", "J", Value),
    spec("quality", "Q", Value),
    idle("bounding", "B", Flag, TREE),
    idle("bounding_threshold", "MB", Either, TREE),
    idle("bounding_method", "BM", Value, TREE),
    idle("bsp_maxdepth", "", Value, TREE),
    idle("bsp_isectcost", "", Value, TREE),
    idle("bsp_baseaccesscost", "", Value, TREE),
    idle("bsp_childaccesscost", "", Value, TREE),
    idle("bsp_misschance", "", Value, TREE),
    idle("remove_bounds", "UR", Flag, TREE),
    idle("split_unions", "SU", Flag, TREE),
    idle("light_buffer", "UL", Flag, TREE),
    idle("vista_buffer", "UV", Flag, TREE),
    idle("draw_vistas", "UD", Flag, TREE),
    spec("input_file_name", "I", Value),
    spec("include_header", "HI", Value),
    spec("library_path", "L", Value),
    spec("include_ini", "", Value),
    spec("version", "MV", Value),
    spec("output_to_file", "F", Flag),
    spec("output_file_type", "F", Value),
    spec("bits_per_color", "", Value),
    spec("grayscale_output", "", Flag),
    spec("output_file_name", "O", Value),
    spec("output_alpha", "UA", Flag),
    spec("compression", "", Value),
    spec("file_gamma", "", Value),
    idle("display_gamma", "", Value, WINDOW),
    spec("dither", "TH", Flag),
    spec("dither_method", "TH", Value),
    spec("continue_trace", "C", Flag),
    spec("clock", "K", Value),
    spec("initial_frame", "KFI", Value),
    spec("final_frame", "KFF", Value),
    spec("initial_clock", "KI", Value),
    spec("final_clock", "KF", Value),
    spec("cyclic_animation", "KC", Flag),
    idle("clockless_animation", "KLA", Flag, "every frame is read anew"),
    spec("real_time_raytracing", "RTR", Flag),
    spec("subset_start_frame", "SF", Value),
    spec("subset_end_frame", "EF", Value),
    spec("frame_step", "STP", Value),
    idle("field_render", "UF", Flag, "POV-Ray takes it and renders whole frames too"),
    idle("odd_field", "UO", Flag, "POV-Ray takes it and renders whole frames too"),
    idle("display", "D", Either, WINDOW),
    idle("video_mode", "", Value, WINDOW),
    idle("palette", "", Value, WINDOW),
    idle("pause_when_done", "P", Flag, WINDOW),
    idle("preview_start_size", "SP", Value, WINDOW),
    idle("preview_end_size", "EP", Value, WINDOW),
    spec("verbose", "V", Flag),
    spec("all_console", "GA", Flag),
    spec("all_file", "GA", Value),
    spec("debug_console", "GD", Flag),
    spec("debug_file", "GD", Value),
    spec("fatal_console", "GF", Flag),
    spec("fatal_file", "GF", Value),
    spec("render_console", "GR", Flag),
    spec("render_file", "GR", Value),
    spec("statistic_console", "GS", Flag),
    spec("statistic_file", "GS", Value),
    spec("warning_console", "GW", Flag),
    spec("warning_file", "GW", Value),
    spec("append_file", "GP", Flag),
    idle("warning_level", "WL", Value, "POV-Ray's has no effect on what a scene is told either"),
    spec("work_threads", "WT", Value),
    spec("render_block_size", "BS", Value),
    idle("render_block_step", "RS", Value, "the order of blocks changes no pixel"),
    idle("render_pattern", "RP", Value, "the order of blocks changes no pixel"),
    spec("high_reproducibility", "HR", Flag),
    idle("radiosity_file_name", "RF", Value, "radiosity is worked out anew for every picture"),
    idle("radiosity_from_file", "RFI", Flag, "radiosity is worked out anew for every picture"),
    idle("radiosity_to_file", "RFO", Flag, "radiosity is worked out anew for every picture"),
    idle("radiosity_vain_pretrace", "RVP", Flag, "radiosity is worked out anew for every picture"),
    idle("max_image_buffer_memory", "MI", Value, "pictures are kept in memory"),
    idle("test_abort", "X", Flag, "POV-Ray's has no effect either"),
    idle("test_abort_count", "X", Value, "POV-Ray's has no effect either"),
    spec("create_ini", "GI", Value),
    spec("declare", "", Value),
    idle("pre_scene_command", "", Value, SHELL),
    idle("pre_frame_command", "", Value, SHELL),
    idle("post_frame_command", "", Value, SHELL),
    idle("post_scene_command", "", Value, SHELL),
    idle("user_abort_command", "", Value, SHELL),
    idle("fatal_error_command", "", Value, SHELL),
    idle("pre_scene_return", "", Value, SHELL),
    idle("pre_frame_return", "", Value, SHELL),
    idle("post_frame_return", "", Value, SHELL),
    idle("post_scene_return", "", Value, SHELL),
    idle("user_abort_return", "", Value, SHELL),
    idle("fatal_error_return", "", Value, SHELL),
    // Our own, as keys only.
    spec("backend", "", Value),
    spec("accel", "", Value),
    spec("allow_io", "", Value),
    spec("max_steps", "", Value),
    spec("max_memory", "", Value),
];

/// Keys of earlier versions: taken in INI files with a note, unknown on the command line.
pub const OLD_KEYS: &[&str] =
    &["buffer_output", "buffer_size", "create_histogram", "histogram_grid_size", "histogram_name", "histogram_type"];
