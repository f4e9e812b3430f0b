//! Which structure `auto` means on a GPU: a small table by device, kind of geometry and size, with a shipped default.
//! `rayloom bench accel --calibrate` measures a scene and writes a line of it.

use crate::accel::AccelKind;
use crate::compile::CompiledScene;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A measured choice.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Choice {
    /// Name of the device, as its driver gives it.
    pub device: String,
    /// Whether the scene is mostly triangles of meshes, or mostly other primitives.
    pub triangles: bool,
    /// Faces and primitives of the scene that was measured.
    pub n_prims: u64,
    /// The fastest structure's name.
    pub accel: String,
}

/// Where the table is: `RAYLOOM_ACCEL_TABLE`, or `rayloom/accel.json` among the user's settings; `None` without a home.
pub fn table_path() -> Option<PathBuf> {
    if let Some(path) = std::env::var_os("RAYLOOM_ACCEL_TABLE") {
        return Some(path.into());
    }
    crate::user_folders::settings().map(|s| s.join("accel.json"))
}

/// The table; empty when there is none or it cannot be read.
pub fn load_table() -> Vec<Choice> {
    let text = table_path().and_then(|p| std::fs::read_to_string(p).ok());
    text.and_then(|t| serde_json::from_str(&t).ok()).unwrap_or_default()
}

/// Puts a choice into the table in place of an older one for the same; gives the table's path.
pub fn save_choice(choice: Choice) -> std::io::Result<PathBuf> {
    let path = table_path().ok_or_else(|| std::io::Error::other("no folder for settings: set RAYLOOM_ACCEL_TABLE"))?;
    let mut table = load_table();
    table.retain(|c| (&c.device, c.triangles, c.n_prims) != (&choice.device, choice.triangles, choice.n_prims));
    table.push(choice);
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    std::fs::write(&path, serde_json::to_string_pretty(&table)?)?;
    Ok(path)
}

/// The table's choice for the nearest size, else the shipped one.
pub fn best_for(info: &wgpu::AdapterInfo, scene: &CompiledScene) -> AccelKind {
    let size = scene.geometry.size();
    choose(&load_table(), &info.name, size.is_triangles(), size.total()).unwrap_or(SHIPPED)
}

fn choose(table: &[Choice], device: &str, triangles: bool, n_prims: u64) -> Option<AccelKind> {
    let apart = |c: &&Choice| (c.n_prims.max(1) as f64).ln() - (n_prims.max(1) as f64).ln();
    let fitting = table.iter().filter(|c| c.device == device && c.triangles == triangles);
    let best = fitting.min_by(|a, b| apart(a).abs().total_cmp(&apart(b).abs()))?;
    AccelKind::named(&best.accel)
}

/// Without a measurement. Source: benches/results/accel_h100.md.
const SHIPPED: AccelKind = AccelKind::Bvh;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_size_decides_and_other_devices_do_not() {
        let line =
            |device: &str, triangles, n_prims, accel: &str| Choice { device: device.into(), triangles, n_prims, accel: accel.into() };
        let table = [line("card", true, 1000, "kd"), line("card", true, 1_000_000, "wide"), line("other", true, 5000, "brute")];
        assert_eq!(choose(&table, "card", true, 5000), Some(AccelKind::Kd));
        assert_eq!(choose(&table, "card", true, 200_000), Some(AccelKind::Wide));
        assert_eq!(choose(&table, "card", false, 5000), None);
        assert_eq!(choose(&table, "third", true, 5000), None);
    }
}
