//! The program as a user meets it: commands, names of pictures, streams, exit codes, interrupts. Bad input stands in `bad_input.rs`.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const SCENE: &str = "#version 3.7; global_settings { assumed_gamma 1 }\n\
    #debug \"hello from the scene\\n\"\n\
    camera { location -5*z }\nlight_source { <4, 6, -8> rgb 1 }\n\
    sphere { 0, 1 pigment { rgb <1, 0.5, 0.2> } translate clock*x }\n";

struct Folder(tempfile::TempDir);

impl Folder {
    fn with_scene() -> Self {
        let dir = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(dir.path().join("s.pov"), SCENE).expect("written");
        Self(dir)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn run(&self, args: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rayloom"));
        // No povray.ini of this machine may change what is tested.
        command.args(args).current_dir(self.0.path()).env_clear().env("POVINI", "/nonexistent");
        // The temporary folder is one that scenes may write to; a checkout may lie in the usual one.
        command.env("TMPDIR", self.0.path());
        command.output().expect("the program starts")
    }
}

fn code(o: &Output) -> i32 {
    o.status.code().expect("no signal")
}

fn err(o: &Output) -> String {
    String::from_utf8_lossy(&o.stderr).into_owned()
}

fn size(path: &Path) -> (u32, u32) {
    image::image_dimensions(path).expect("a picture")
}

#[test]
fn render_writes_the_picture_and_says_where_it_ran() {
    let f = Folder::with_scene();
    let o = f.run(&["render", "s.pov", "-o", "out.png", "--size", "40x30", "--backend", "cpu"]);
    assert_eq!(code(&o), 0, "{}", err(&o));
    assert_eq!(size(&f.path("out.png")), (40, 30));
    assert!(err(&o).contains("hello from the scene") && err(&o).contains("CPU"), "{}", err(&o));
    assert!(o.stdout.is_empty(), "standard output is for data");
}

#[test]
fn json_progress_is_one_object_a_line_and_ends_with_the_statistics() {
    let f = Folder::with_scene();
    let o =
        f.run(&["render", "s.pov", "-o", "out.png", "--size", "40x30", "--backend", "cpu", "--progress", "json", "--stats", "stats.json"]);
    assert_eq!(code(&o), 0, "{}", err(&o));
    let lines: Vec<serde_json::Value> =
        String::from_utf8_lossy(&o.stdout).lines().map(|l| serde_json::from_str(l).expect("JSON")).collect();
    let events: Vec<&str> = lines.iter().filter_map(|l| l["event"].as_str()).collect();
    assert_eq!((events.first(), events.last()), (Some(&"loading"), Some(&"finished")));
    assert!(events.contains(&"progress") && events.contains(&"rendering"), "{events:?}");
    let stats: serde_json::Value = serde_json::from_slice(&std::fs::read(f.path("stats.json")).expect("a file")).expect("JSON");
    assert_eq!((stats["width"].as_u64(), stats["primitives"].as_u64()), (Some(40), Some(1)));
}

#[test]
fn povray_takes_its_options_and_keeps_standard_output_clean() {
    let f = Folder::with_scene();
    let o = f.run(&["povray", "+Is.pov", "+W20", "+H10", "-D", "-P", "-A", "+GDdebug.txt", "Backend=cpu"]);
    assert_eq!(code(&o), 0, "{}", err(&o));
    assert_eq!(size(&f.path("s.png")), (20, 10));
    assert_eq!(std::fs::read_to_string(f.path("debug.txt")).expect("debug.txt"), "hello from the scene\n");
    assert!(o.stdout.is_empty() && err(&o).contains("POV-Ray finished"), "{}", err(&o));
}

#[test]
fn a_picture_goes_to_standard_output_when_asked() {
    let f = Folder::with_scene();
    let o = f.run(&["povray", "+Is.pov", "+O-", "+W20", "+H10", "Backend=cpu"]);
    assert_eq!(code(&o), 0, "{}", err(&o));
    assert_eq!(image::load_from_memory(&o.stdout).expect("a picture").width(), 20);
    assert!(!f.path("s.png").exists());
}

#[test]
fn parse_errors_have_povrays_line_and_exit_code_1() {
    let f = Folder::with_scene();
    std::fs::write(f.path("bad.pov"), "sphere { 0, 1 }\n\nbox { 0, 1 pigmet { rgb 1 } }\n").expect("written");
    let o = f.run(&["povray", "+Ibad.pov"]);
    assert_eq!(code(&o), 1);
    let text = err(&o);
    assert!(text.contains("File 'bad.pov' line 3: Parse Error: No matching } in 'box'"), "{text}");
    assert!(text.contains("bad.pov:3:12") && text.contains("^^^^^^"), "{text}");
    let o = f.run(&["render", "bad.pov", "-o", "bad.png"]);
    assert_eq!(code(&o), 3);
    assert!(!f.path("bad.png").exists());
}

#[test]
fn animations_number_their_pictures_and_move_the_clock() {
    let f = Folder::with_scene();
    std::fs::write(f.path("a.ini"), "Input_File_Name=s.pov\nFinal_Frame=12\nSubset_Start_Frame=9\n+W16 +H12\nBackend=cpu\n")
        .expect("written");
    let o = f.run(&["povray", "a.ini", "+EF10"]);
    assert_eq!(code(&o), 0, "{}", err(&o));
    let pictures = ["s09.png", "s10.png"].map(|n| std::fs::read(f.path(n)).expect("a frame"));
    assert!(!f.path("s11.png").exists() && pictures[0] != pictures[1]);
    let o = f.run(&["render", "s.pov", "-o", "f.png", "--frames", "1..2", "--size", "16x12", "--backend", "cpu"]);
    assert_eq!(code(&o), 0, "{}", err(&o));
    assert!(f.path("f1.png").exists() && f.path("f2.png").exists());
}

#[test]
fn a_crop_is_the_whole_pictures_pixels() {
    let f = Folder::with_scene();
    for (name, extra) in [("all.png", None), ("part.png", Some("+SC9 +EC0.8 +SR0.25 +ER20"))] {
        let out = format!("+O{name}");
        let mut args = vec!["povray", "+Is.pov", &out, "+W40", "+H30", "+A0.1", "-J", "Backend=cpu"];
        args.extend(extra.iter().flat_map(|e| e.split(' ')));
        assert_eq!(code(&f.run(&args)), 0);
    }
    let [all, part] = ["all.png", "part.png"].map(|n| image::open(f.path(n)).expect("a picture").to_rgb8());
    assert_eq!(part.dimensions(), (40, 30));
    for (x, y, p) in part.enumerate_pixels() {
        let inside = (8..32).contains(&x) && (7..20).contains(&y);
        // Border pixels of a part are antialiased against other neighbours than in the whole.
        if !inside {
            assert_eq!(p.0, [0; 3]);
        } else if (10..30).contains(&x) && (9..18).contains(&y) {
            assert_eq!(p, all.get_pixel(x, y));
        }
    }
}

#[test]
fn the_picture_does_not_depend_on_the_threads() {
    let f = Folder::with_scene();
    for (name, threads) in [("one.png", "+WT1"), ("four.png", "+WT4")] {
        let o = f.run(&["povray", "+Is.pov", &format!("+O{name}"), "+W64", "+H48", "+A0.05", threads, "Backend=cpu"]);
        assert_eq!(code(&o), 0, "{}", err(&o));
    }
    assert_eq!(std::fs::read(f.path("one.png")).ok(), std::fs::read(f.path("four.png")).ok());
}

#[test]
fn info_lists_what_a_scene_uses_and_what_was_left_out() {
    let f = Folder::with_scene();
    let o = f.run(&["info", "s.pov", "--json"]);
    assert_eq!(code(&o), 0, "{}", err(&o));
    let info: serde_json::Value = serde_json::from_slice(&o.stdout).expect("JSON");
    assert_eq!(info["primitives"]["Sphere"].as_u64(), Some(1));
    assert!(info["left_out"].as_array().is_some_and(|l| l.iter().any(|v| v == "fog")), "{info}");
    assert_eq!(code(&f.run(&["info"])), 0);
}

#[test]
fn scenes_write_to_their_own_folders_only() {
    let f = Folder::with_scene();
    let outside = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).expect("a folder");
    let target = outside.path().join("x.txt").display().to_string();
    let scene = format!("#fopen F \"{target}\" write\n#write(F, \"1\\n\")\n#fclose F\ncamera {{ location -z }}\n");
    std::fs::write(f.path("w.pov"), scene).expect("written");
    let o = f.run(&["povray", "+Iw.pov", "-F", "Backend=cpu"]);
    assert_eq!(code(&o), 1);
    assert!(err(&o).contains("outside the folders") && !Path::new(&target).exists(), "{}", err(&o));
    let allow = format!("Allow_IO={}", outside.path().display());
    assert_eq!(code(&f.run(&["povray", "+Iw.pov", "-F", &allow, "Backend=cpu"])), 0);
    assert!(Path::new(&target).exists());
}

/// Slow enough to be interrupted, fast enough to be finished.
const SLOW: &str = "#version 3.7; global_settings { assumed_gamma 1 }\ncamera { location -5*z }\n\
    light_source { <4, 6, -8> rgb 1 area_light 3*x, 3*y, 24, 24 }\nplane { y, -1 pigment { rgb 0.8 } }\n\
    union { #for (I, 0, 99) sphere { <mod(I, 10) - 5, div(I, 10)/5 - 1, mod(I, 7)/3>, 0.4 } #end pigment { bozo } }\n";

#[test]
fn a_renderer_ends_with_the_program_that_started_it() {
    use std::io::{BufRead, BufReader};
    use std::process::Stdio;
    let f = Folder::with_scene();
    std::fs::write(f.path("slow.pov"), SLOW).expect("written");
    let args = ["render", "slow.pov", "-o", "p.png", "--size", "1600x1200", "--backend", "cpu", "--progress", "json", "--stop-with-stdin"];
    let mut child = Command::new(env!("CARGO_BIN_EXE_rayloom"))
        .args(args)
        .current_dir(f.0.path())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    let mut lines = BufReader::new(child.stdout.take().expect("piped")).lines();
    assert!(lines.by_ref().map_while(Result::ok).any(|l| l.contains("\"progress\"")), "finished before its parent did");
    // As when the parent is gone.
    drop(child.stdin.take());
    lines.for_each(drop);
    assert_eq!(child.wait().expect("ends").code(), Some(130));
}

#[cfg(unix)]
#[test]
fn an_interrupt_saves_what_is_rendered_and_resume_goes_on_from_it() {
    use std::io::{BufRead, BufReader};
    let f = Folder::with_scene();
    std::fs::write(f.path("slow.pov"), SLOW).expect("written");
    let args = ["render", "slow.pov", "-o", "p.png", "--size", "320x240", "--backend", "cpu", "--threads", "1", "--progress", "json"];
    let mut child = Command::new(env!("CARGO_BIN_EXE_rayloom"))
        .args(args)
        .current_dir(f.0.path())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("the program starts");
    let mut lines = BufReader::new(child.stdout.take().expect("piped")).lines();
    let rendered = lines.by_ref().map_while(Result::ok).filter(|l| l.contains("\"progress\"")).nth(2);
    assert!(rendered.is_some(), "finished before it could be interrupted");
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    assert!(kill.success());
    lines.for_each(drop);
    assert_eq!(child.wait().expect("ends").code(), Some(130));
    assert!(f.path("p.png").exists() && f.path("p.rayloom-state").exists(), "what was rendered is kept");
    let mut resume = args.to_vec();
    resume.push("--resume");
    let o = f.run(&resume);
    assert_eq!(code(&o), 0, "{}", err(&o));
    let resumed = String::from_utf8_lossy(&o.stdout).lines().any(|l| l.contains("resumed_pixels") && !l.contains("\"resumed_pixels\":0"));
    assert!(resumed, "{}", String::from_utf8_lossy(&o.stdout));
    assert!(!f.path("p.rayloom-state").exists());
    let mut whole = args.to_vec();
    whole[3] = "whole.png";
    assert_eq!(code(&f.run(&whole)), 0);
    assert_eq!(std::fs::read(f.path("p.png")).ok(), std::fs::read(f.path("whole.png")).ok());
}

#[test]
fn a_denoiser_that_is_not_there_is_an_error_before_the_first_ray() {
    let f = Folder::with_scene();
    let render = |more: &[&str]| f.run(&[&["render", "s.pov", "-o", "o.png", "--size", "32x24"], more].concat());
    let o = render(&["--integrator", "path", "--denoise", "--denoise-library", "nowhere"]);
    assert_eq!(code(&o), 5, "{}", err(&o));
    assert!(!f.path("o.png").exists());
    if cfg!(feature = "denoise") {
        assert!(err(&o).contains("nowhere") && err(&o).contains("--no-denoise"), "{}", err(&o));
    }
    let o = render(&["--denoise"]);
    assert!(code(&o) == 2 && err(&o).contains("path integrator"), "{}", err(&o));
    assert_eq!(code(&render(&["--integrator", "path", "--spp", "1", "--no-denoise"])), 0);
}

#[test]
fn a_time_limit_ends_a_picture_and_says_how_many_samples_it_has() {
    let f = Folder::with_scene();
    let limited = ["render", "s.pov", "-o", "o.exr", "--size", "32x24", "--time-limit", "0.2", "--spp", "1000000"];
    let o = f.run(&[&limited[..], &["--integrator", "path", "--backend", "cpu", "--stats", "t.json"]].concat());
    assert!(code(&o) == 0 && err(&o).contains("in the time limit"), "{}", err(&o));
    let stats: serde_json::Value = serde_json::from_slice(&std::fs::read(f.path("t.json")).expect("written")).expect("JSON");
    let samples = &stats["samples"];
    assert!(samples["least"].as_u64() >= Some(1) && samples["most"].as_u64() < Some(1_000_000), "{samples}");
    assert_eq!(samples["time_limit_reached"], true);
    let o = f.run(&limited);
    assert!(code(&o) == 2 && err(&o).contains("path integrator"), "{}", err(&o));
}

/// Something for every saving of the CPU: a mesh in view and one behind the camera, lights of all sides with an
/// area light, glass with an interior, a mirror.
const THRIFTY: &str = "#version 3.7; global_settings { assumed_gamma 1 max_trace_level 8 }\n\
    camera { location -6*z+y look_at 0 }\nlight_source { <4, 6, -8> rgb 0.6 }\nlight_source { <-4, -6, 8> rgb 0.3 }\n\
    light_source { <-3, 5, -3> rgb 0.5 area_light x, z, 6, 6 adaptive 1 }\n\
    #for (K, 0, 2) sphere { <K - 1, 0.5, 0>, 0.4 pigment { rgbf 0.9 } finish { reflection 0.3 } interior { ior 1.4 } } #end\n\
    plane { y, -0.5 pigment { checker rgb 1, rgb 0.3 } finish { reflection 0.2 } }\n\
    #declare M = mesh { triangle { <-2, 0, 1>, <2, 0, 1>, <0, 2, 1> } triangle { <-2, 0, 1>, <2, 0, 1>, <0, -1, 2> } pigment { rgb <1, 0, 0> } }\n\
    object { M }\nobject { M translate -40*z }\n";

#[test]
fn every_saving_keeps_the_picture_or_says_that_it_does_not() {
    let f = Folder::with_scene();
    std::fs::write(f.path("t.pov"), THRIFTY).expect("written");
    let o = f.run(&["bench", "skip", "t.pov", "--size", "64x48", "--rounds", "1", "--backend", "cpu", "--csv", "t.csv"]);
    let table = String::from_utf8_lossy(&o.stdout).into_owned();
    assert_eq!(code(&o), 0, "{table}{}", err(&o));
    let line = |name: &str| table.lines().find(|l| l.starts_with(name)).unwrap_or_else(|| panic!("no {name}: {table}"));
    for name in ["trees", "frames", "lights", "blockers", "interiors", "shafts"] {
        assert!(line(name).ends_with("  equal"), "{}", line(name));
    }
    for name in ["bailout", "antialias"] {
        assert!(line(name).contains("values differ by nature"), "{}", line(name));
    }
    for name in ["textures", "shaders", "attributes"] {
        assert!(line(name).contains("not measured"), "{}", line(name));
    }
    assert_eq!(std::fs::read_to_string(f.path("t.csv")).expect("a table").lines().count(), 12);
    let info = f.run(&["info", "t.pov"]);
    assert!(String::from_utf8_lossy(&info.stdout).contains("rayloom bench skip"));
    assert_eq!(code(&f.run(&["render", "t.pov", "--no-skip=lamps"])), 2);
    let picture = |options: &[&str]| {
        let all = [&["render", "t.pov", "-o", "p.png", "--size", "64x48", "--backend", "cpu"], options].concat();
        assert_eq!(code(&f.run(&all)), 0);
        std::fs::read(f.path("p.png")).expect("a picture")
    };
    let with = picture(&[]);
    assert!(with == picture(&["--no-skip"]) && with == picture(&["--no-skip=lights,shafts"]));
    assert!(with != picture(&["--no-skip=bailout"]), "a switch that does something");
}
