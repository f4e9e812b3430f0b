//! The suite can fail: every kind of wrong picture, file and harness is caught, and what is right passes. On suites in temporary folders,
//! through the command line as a user would.

use image::RgbImage;
use std::path::{Path, PathBuf};
use std::process::Command;

const SCENE: &str = "// A ball.\n#version 3.7; global_settings { assumed_gamma 1 } camera { location -4*z angle 50 right 4/3*x }\n\
    light_source { <3, 4, -5> rgb 1 } background { rgb <0.3, 0.4, 0.6> }\n\
    sphere { 0, 1 pigment { rgb <0.9, 0.5, 0.2> } finish { phong 0.6 } }\n\
    plane { y, -1 pigment { checker rgb 0.9 rgb <0.2, 0.5, 0.3> } }\n";
/// The suite's table as the project's own suite has it: what it lets through is what counts.
const TABLE: &str = include_str!("scenes/suite.toml");

struct Bench {
    dir: tempfile::TempDir,
}

struct Ran {
    code: i32,
    told: String,
}

impl Bench {
    /// A suite of `n` cases with golden pictures of their own, which passes.
    fn new(n: usize) -> Self {
        let bench = Self { dir: tempfile::tempdir().expect("a temporary folder") };
        let table =
            TABLE.replace("\"../../references\"", "\"references\"").replace("backends = [\"cpu\", \"gpu\"]", "backends = [\"cpu\"]");
        let table: String = table.lines().filter(|l| !l.starts_with("cases_at_least")).map(|l| format!("{l}\n")).collect();
        bench.write("suite.toml", &table);
        for k in 0..n {
            bench.write(&format!("area/case{k}/scene.pov"), SCENE);
            bench.write(&format!("area/case{k}/test.toml"), "references = [\"golden\", \"povray\"]\n");
        }
        assert_eq!(bench.run(&["--update", "--all"]).code, 2, "an update fails the run");
        let golden = bench.path("references/golden/area");
        let povray = bench.path("references/povray-3.7.0.10/area");
        std::fs::create_dir_all(&povray).expect("writable");
        for k in 0..n {
            std::fs::copy(golden.join(format!("case{k}.png")), povray.join(format!("case{k}.png"))).expect("updated");
        }
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join("suite").join(name)
    }

    fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().expect("inside")).expect("writable");
        std::fs::write(path, text).expect("writable");
    }

    fn run(&self, args: &[&str]) -> Ran {
        let out = Command::new(env!("CARGO_BIN_EXE_rayloom"))
            .arg("suite")
            .arg("suite")
            .args(["--out", "out"])
            .args(args)
            .current_dir(self.dir.path())
            .output()
            .expect("rayloom starts");
        let told = String::from_utf8_lossy(&out.stdout).into_owned() + &String::from_utf8_lossy(&out.stderr);
        Ran { code: out.status.code().unwrap_or(-1), told }
    }

    fn result(&self) -> serde_json::Value {
        let text = std::fs::read(self.dir.path().join("out/results.json")).expect("results");
        serde_json::from_slice(&text).expect("JSON")
    }

    fn golden(&self) -> PathBuf {
        self.path("references/golden/area/case0.png")
    }

    /// Changes a reference picture.
    fn change(&self, path: &Path, f: impl Fn(&RgbImage) -> RgbImage) {
        let p = image::open(path).expect("a picture").to_rgb8();
        f(&p).save(path).expect("writable");
    }

    /// Runs with a changed reference of each kind, which both pairs must see unless `golden_only`.
    fn is_caught(&self, what: &str, golden_only: bool, f: impl Fn(&RgbImage) -> RgbImage) {
        let references = [(self.golden(), "cpu-golden"), (self.path("references/povray-3.7.0.10/area/case0.png"), "cpu-povray")];
        for (path, pair) in &references[..if golden_only { 1 } else { 2 }] {
            let before = std::fs::read(path).expect("a picture");
            self.change(path, &f);
            let ran = self.run(&[]);
            assert!(ran.code == 2 && ran.told.contains(&format!("{pair}: ")), "{what} in {pair}: {} {}", ran.code, ran.told);
            std::fs::write(path, before).expect("writable");
        }
        assert_eq!(self.run(&[]).code, 0, "what is restored passes");
    }
}

#[test]
fn every_wrong_picture_is_caught() {
    let b = Bench::new(1);
    let pass = b.run(&[]);
    assert!(pass.code == 0 && pass.told.contains("1 cases") && pass.told.contains("1 passed"), "{}", pass.told);
    b.is_caught("one pixel", true, |p| {
        let mut q = p.clone();
        q.get_pixel_mut(40, 30).0[1] ^= 0x40;
        q
    });
    b.is_caught("red and blue swapped", false, |p| {
        RgbImage::from_fn(p.width(), p.height(), |x, y| {
            let [r, g, b] = p.get_pixel(x, y).0;
            image::Rgb([b, g, r])
        })
    });
    b.is_caught("shifted by a pixel", false, |p| {
        RgbImage::from_fn(p.width(), p.height(), |x, y| *p.get_pixel((x + 1).min(p.width() - 1), y))
    });
    b.is_caught("1 % brighter", false, |p| {
        RgbImage::from_fn(p.width(), p.height(), |x, y| {
            image::Rgb(p.get_pixel(x, y).0.map(|v| (f64::from(v) * 1.01).round().min(255.0) as u8))
        })
    });
    b.is_caught("with noise", false, |p| {
        RgbImage::from_fn(p.width(), p.height(), |x, y| {
            let n = (x.wrapping_mul(2_654_435_761) ^ y.wrapping_mul(40_503_123)) >> 7;
            image::Rgb(p.get_pixel(x, y).0.map(|v| (i32::from(v) + (n % 9) as i32 - 4).clamp(0, 255) as u8))
        })
    });
    b.is_caught("of another size", false, |p| image::imageops::crop_imm(p, 0, 0, p.width() - 1, p.height()).to_image());
}

#[test]
fn what_is_missing_is_caught() {
    let b = Bench::new(2);
    let golden = std::fs::read(b.golden()).expect("a picture");
    std::fs::remove_file(b.golden()).expect("it is there");
    let ran = b.run(&[]);
    assert!(ran.code == 4 && ran.told.contains("cannot read"), "a deleted reference: {}", ran.told);
    std::fs::write(b.golden(), b"no picture").expect("writable");
    assert_eq!(b.run(&[]).code, 4, "a reference that is no picture");
    std::fs::write(b.golden(), golden).expect("writable");

    std::fs::rename(b.path("area/case1"), b.dir.path().join("away")).expect("movable");
    let ran = b.run(&[]);
    assert!(ran.code == 2 && ran.told.contains("no case asks for the reference golden/area/case1.png"), "a dropped case: {}", ran.told);
    std::fs::rename(b.dir.path().join("away"), b.path("area/case1")).expect("movable");
    std::fs::remove_file(b.path("area/case1/test.toml")).expect("it is there");
    let ran = b.run(&[]);
    assert!(ran.code == 2 && ran.told.contains("area/case1/scene.pov has no test.toml"), "{}", ran.told);
    b.write("area/case1/test.toml", "references = [\"golden\", \"povray\"]\n");
    let table = std::fs::read_to_string(b.path("suite.toml")).expect("readable");
    b.write("suite.toml", &format!("cases_at_least = 3\n{table}"));
    assert_eq!(b.run(&[]).code, 4, "fewer cases than there must be");
    assert_eq!(b.run(&["no_such_case"]).code, 4);
    b.write("suite.toml", &table);
    assert_eq!(b.run(&["no_such_case"]).code, 2);
    assert_eq!(b.run(&["case1"]).code, 0);
}

#[test]
fn specifications_are_strict() {
    let b = Bench::new(1);
    for (text, part) in [
        ("referenzes = []", "unknown field"),
        ("references = [\"golde\"]", "no reference is called"),
        ("references = [\"golden\"]\n[tolerance.cpu-golden]\nfail = 0.5", "wants a reason"),
        ("[tolerance.cpu-gold]\nfail = 0.5\nreason = \"x\"", "no comparison"),
        ("[tolerance.cpu-golden]\nfale = 0.5\nreason = \"x\"", "unknown field"),
        ("[tolerance.cpu-golden]\npercent = 5.0\nreason = \"x\"", "nothing is judged"),
        ("[[known_failure]]\npair = \"cpu-golden\"\nreason = \" \"", "wants a reason"),
        ("seeds = [1]", "one seed"),
        ("size = [0, 4]", "above 0"),
        ("scene = \"other.pov\"", "no scene"),
        ("backends = [\"tpu\"]", "unknown variant"),
    ] {
        b.write("area/case0/test.toml", text);
        let ran = b.run(&[]);
        assert!(ran.code == 4 && ran.told.contains(part) && ran.told.contains("test.toml"), "{text}: {} {}", ran.code, ran.told);
    }
}

#[test]
fn a_known_failure_fails_as_recorded_and_no_otherwise() {
    let b = Bench::new(1);
    let toml = "references = [\"golden\", \"povray\"]\n[[known_failure]]\npair = \"cpu-povray\"\nreason = \"a test\"\n";
    b.write("area/case0/test.toml", toml);
    let ran = b.run(&[]);
    assert!(ran.code == 2 && ran.told.contains("agrees now"), "one that passes fails: {}", ran.told);
    let povray = b.path("references/povray-3.7.0.10/area/case0.png");
    b.change(&povray, |p| RgbImage::from_pixel(p.width(), p.height(), image::Rgb([9, 9, 9])));
    assert_eq!(b.run(&[]).code, 4, "its wrong picture is not recorded");
    b.run(&["--update", "case0"]);
    let ran = b.run(&[]);
    assert!(ran.code == 0 && ran.told.contains("1 known failure") && ran.told.contains("a test"), "{}", ran.told);
    b.change(&b.path("references/known_failures/area/case0.cpu-povray.png"), image::imageops::flip_vertical);
    let ran = b.run(&[]);
    assert!(ran.code == 2 && ran.told.contains("otherwise than recorded"), "{}", ran.told);
}

#[test]
fn texts_are_held_against_golden_ones() {
    let b = Bench::new(1);
    b.write("area/wrong/scene.pov", "#version 3.7;\nsphere { 0, 1 pigmnt { rgb 1 } }\n");
    b.write("area/wrong/test.toml", "about = \"a slip of the pen\"\nexpect = \"error\"\n");
    b.write("area/case0/test.toml", "references = [\"golden\", \"povray\"]\ndump = true\n");
    assert_eq!(b.run(&[]).code, 2, "there are no golden texts yet");
    b.run(&["--update", "--all"]);
    let ran = b.run(&[]);
    assert_eq!(ran.code, 0, "{}", ran.told);
    let told = std::fs::read_to_string(b.path("references/golden/area/wrong.diagnostics.txt")).expect("updated");
    assert!(told.contains("pigmnt"), "{told}");
    let scene = std::fs::read_to_string(b.path("references/golden/area/case0.scene.txt")).expect("updated");
    assert!(scene.starts_with("Scene {") && scene.contains("Sphere"), "{scene}");
    b.write("area/wrong/scene.pov", "#version 3.7;\nsphere { 0, 1 pigmint { rgb 1 } }\n");
    b.write("area/case0/scene.pov", &SCENE.replace("phong 0.6", "phong 0.6 crand 0"));
    let ran = b.run(&["wrong"]);
    assert!(ran.code == 2 && ran.told.contains("the diagnostics text differs"), "{}", ran.told);
    b.write("area/wrong/scene.pov", SCENE);
    let ran = b.run(&["wrong"]);
    assert!(ran.code == 4 && ran.told.contains("an error is expected"), "{}", ran.told);
    b.write("area/case0/scene.pov", &SCENE.replace("<3, 4, -5>", "<3.001, 4, -5>"));
    let ran = b.run(&["case0"]);
    assert!(ran.code == 2 && ran.told.contains("the scene text differs"), "{}", ran.told);
}

#[test]
fn unchanged_cases_are_taken_over_and_changed_ones_are_not() {
    let b = Bench::new(2);
    b.run(&[]);
    let ran = b.run(&["--skip-unchanged"]);
    assert!(ran.code == 0 && ran.told.matches("unchanged").count() == 2, "{}", ran.told);
    b.write("area/case1/scene.pov", &SCENE.replace("0.9, 0.5, 0.2", "0.2, 0.5, 0.9"));
    let ran = b.run(&["--skip-unchanged"]);
    assert!(ran.code == 2 && ran.told.matches("unchanged").count() == 1, "{}", ran.told);
    // A failure is not taken over: it is run until it passes.
    assert_eq!(b.run(&["--skip-unchanged"]).code, 2);
}

#[test]
fn reports_are_whole() {
    let b = Bench::new(2);
    b.change(&b.golden(), image::imageops::flip_horizontal);
    let ran = b.run(&["--junit", "out/junit.xml", "--sidecar", "--report", "out/other.html"]);
    assert_eq!(ran.code, 2);
    let xml = std::fs::read_to_string(b.dir.path().join("out/junit.xml")).expect("written");
    assert!(xml.contains("tests=\"2\" failures=\"1\" errors=\"0\"") && xml.contains("<failure message=\"cpu-golden: "), "{xml}");
    let page = std::fs::read_to_string(b.dir.path().join("out/other.html")).expect("written");
    assert!(page.contains("area/case0") && !page.contains("text/plain") && !page.contains("http://") && !page.contains("https://"));
    assert!(std::fs::read_dir(b.dir.path().join("out/other_pictures")).expect("a folder").count() >= 2);
    assert_eq!(b.run(&[]).code, 2);
    let page = std::fs::read_to_string(b.dir.path().join("out/report.html")).expect("written");
    assert!(page.contains("<script type=\"text/plain\" id=\"p"));
    let json = b.run(&["--json"]);
    let start = json.told.find('{').expect("JSON");
    let value: serde_json::Value = serde_json::from_str(&json.told[start..]).expect("JSON");
    assert_eq!(value["cases"][0]["state"], "failed");
    assert!(value["cases"][1]["runs"][0]["last_seconds"].as_f64().is_some_and(|s| s > 0.0), "the last run's time");
}

#[test]
fn a_newcomer_adds_a_case_in_three_commands() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(dir.path().join("ball.pov"), SCENE).expect("writable");
    let run = |args: &[&str]| {
        let out = Command::new(env!("CARGO_BIN_EXE_rayloom")).arg("suite").args(args).current_dir(dir.path()).output().expect("it starts");
        (out.status.code(), String::from_utf8_lossy(&out.stdout).into_owned() + &String::from_utf8_lossy(&out.stderr))
    };
    let new = ["my-suite", "--new", "balls/ball", "--scene", "ball.pov"];
    assert_eq!(run(&new).0, Some(0));
    assert_eq!(run(&["my-suite", "--update", "balls/ball"]).0, Some(2));
    let (code, told) = run(&["my-suite"]);
    assert!(code == Some(0) && told.contains("1 passed"), "{told}");
    assert_eq!(run(&new).0, Some(2), "the name is taken");
    let (code, told) = run(&["no-suite"]);
    assert!(code == Some(2) && told.contains("no folder"), "{told}");
}

/// Programs that do wrong in the place of ours.
#[cfg(unix)]
mod wrong_programs {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    impl Bench {
        /// A script that stands in for `rayloom`, which it calls `$REAL`.
        fn program(&self, body: &str) -> String {
            let path = self.dir.path().join("program.sh");
            let text = format!("#!/bin/sh\nREAL='{}'\n{body}\n", env!("CARGO_BIN_EXE_rayloom"));
            std::fs::write(&path, text).expect("writable");
            std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).expect("executable");
            path.display().to_string()
        }

        fn run_with(&self, body: &str, args: &[&str]) -> Ran {
            let program = self.program(body);
            self.run(&[&["--program", &program], args].concat())
        }
    }

    /// Does on the CPU what the GPU is asked for.
    const ON_THE_CPU: &str = "case \"$1\" in info) echo '{\"gpus\": [\"a card\"]}'; exit 0;; esac\n\
        for a in \"$@\"; do case \"$a\" in Backend=gpu) set -- \"$@\" Backend=cpu;; Statistic_File=*) stats=${a#*=};; +O*) out=${a#+O};; esac; done\n\
        \"$REAL\" \"$@\" || exit 1\n";

    #[test]
    fn the_cpus_picture_handed_in_as_the_gpus_is_caught() {
        let b = Bench::new(8);
        for k in 0..8 {
            b.write(&format!("area/case{k}/test.toml"), "references = [\"golden\", \"povray\"]\nbackends = [\"cpu\", \"gpu\"]\n");
        }
        let honest = b.run_with(ON_THE_CPU, &[]);
        assert!(honest.code == 2 && honest.told.contains("gpu: declined"), "it says that the CPU rendered: {}", honest.told);
        let lying = format!(
            "{ON_THE_CPU}case \"$*\" in *Backend=gpu*) sed -i 's/on CPU, [0-9]* threads*/on a card/' \"$(dirname \"$out\")/$stats\";; esac"
        );
        let ran = b.run_with(&lying, &[]);
        assert!(
            ran.code == 4 && b.result()["cases"][3]["why"][0].as_str().is_some_and(|w| w.contains("cannot be the GPU's own")),
            "{}",
            ran.told
        );
    }

    #[test]
    fn crashes_hangs_and_empty_hands_are_caught() {
        let b = Bench::new(1);
        for (body, part) in [
            ("exit 0", "there is no picture"),
            ("kill -9 $$", "crashed"),
            ("echo 'thread panicked at src/x.rs' >&2; exit 1", "crashed: thread panicked"),
            ("echo 'error: no memory' >&2; exit 5", "exit code 5: error: no memory"),
        ] {
            let ran = b.run_with(body, &[]);
            assert!(ran.code == 4 && ran.told.contains(part), "{body}: {} {}", ran.code, ran.told);
        }
        let table = std::fs::read_to_string(b.path("suite.toml")).expect("readable");
        b.write("suite.toml", &table.replace("timeout_s = 120", "timeout_s = 0.3"));
        let ran = b.run_with("exec sleep 20", &[]);
        assert!(ran.code == 4 && ran.told.contains("stopped after 0.3 s"), "{}", ran.told);
        // A picture of an earlier run is not taken for this one's.
        b.write("suite.toml", &table);
        assert_eq!(b.run(&[]).code, 0);
        assert_eq!(b.run_with("exit 0", &[]).code, 4);
    }

    #[test]
    fn noisy_pictures_pass_by_chance_only() {
        let b = Bench::new(1);
        let obj = "o Ball\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n";
        b.write("area/noisy/scene.obj", obj);
        b.write("area/noisy/test.toml", "about = \"a triangle's edges\"\nreferences = [\"golden\"]\nseeds = [1, 2, 3, 4, 5, 6]\noptions = \"--spp 4\"\n[tolerance.cpu-golden]\nsignificance = 0.01\nsignificant_percent = 0.1\nmean_ratio = 0.01\nfail = 1.0\nhard_fail = 1.0\nreason = \"noisy\"\n");
        b.run(&["--update", "noisy"]);
        assert_eq!(b.run(&["noisy"]).code, 0);
        let toml = std::fs::read_to_string(b.path("area/noisy/test.toml")).expect("readable");
        b.write("area/noisy/test.toml", &toml.replace("[1, 2, 3, 4, 5, 6]", "[11, 12, 13, 14, 15, 16]"));
        let ran = b.run(&["noisy"]);
        assert_eq!(ran.code, 0, "other seeds, the same light: {}", ran.told);
        b.write("area/noisy/scene.obj", &obj.replace("v 0 1 0", "v 0 0.9 0"));
        let ran = b.run(&["noisy"]);
        assert!(ran.code == 2 && ran.told.contains("beyond chance"), "another shape: {}", ran.told);
    }
}
