//! Where the user's settings and what can be made again are kept, on each system.

use std::path::PathBuf;

/// `rayloom` among the user's settings: `$XDG_CONFIG_HOME`, `%APPDATA%`, `~/.config`; `None` without a home.
pub fn settings() -> Option<PathBuf> {
    folder(&["XDG_CONFIG_HOME", "APPDATA"], ".config")
}

/// `rayloom` among the user's caches: `$XDG_CACHE_HOME`, `%LOCALAPPDATA%`, `~/.cache`; `None` without a home.
pub fn cache() -> Option<PathBuf> {
    folder(&["XDG_CACHE_HOME", "LOCALAPPDATA"], ".cache")
}

fn folder(variables: &[&str], in_home: &str) -> Option<PathBuf> {
    let var = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let named = variables.iter().find_map(|name| var(name));
    named.or_else(|| var("HOME").map(|h| h.join(in_home))).map(|f| f.join("rayloom"))
}
