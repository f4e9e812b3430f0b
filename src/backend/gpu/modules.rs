//! The text of every shader module, embedded. A file in `shaders/` that is not listed here does not exist for the program.

macro_rules! modules {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../../shaders/", $name, ".wesl")))),*]
    };
}

/// Name (path below `shaders/` without extension) and text.
pub const MODULES: &[(&str, &str)] = modules![
    "probes/double",
    "shared/words",
];
