//! rayloom's own suite (`tests/scenes/`), as `rayloom suite` runs it, on the CPU: `test.sh` runs it on the GPU too and keeps the report.

use std::path::Path;
use std::process::Command;

#[test]
fn our_pictures_agree_with_their_references() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let run = Command::new(env!("CARGO_BIN_EXE_rayloom"))
        .args(["suite", "tests/scenes", "--backend", "cpu", "--quiet", "--out", "target/pictures"])
        .current_dir(root)
        .output()
        .expect("rayloom starts");
    let told = String::from_utf8_lossy(&run.stdout);
    println!("{told}");
    assert_eq!(run.status.code(), Some(0), "{told}{}", String::from_utf8_lossy(&run.stderr));
    assert!(told.contains("passed"), "{told}");
}
