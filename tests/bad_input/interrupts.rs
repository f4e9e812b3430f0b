//! Signals: Ctrl-C while reading and while rendering, and a kill at any moment.

use super::run::{Folder, finish, signal, wait_for};
use super::{Case, judge};
use std::time::Duration;

/// Rows of easy pixels, then a pixel that takes longer than anyone waits: mirrors in mirrors, no ray too weak.
const SLOW: &str =
    "#version 3.7; global_settings { max_trace_level 200 adc_bailout 0 } camera { orthographic location -9*z right 8*x up 6*y }
plane { z, 9 pigment { rgb 1 } finish { ambient 1 } }
#macro Ball(R) sphere { -2*y, R pigment { rgbt 1 } finish { reflection 1 } interior { ior 1.1 } } #end Ball(1) Ball(0.8) Ball(0.6)";

const OLD: &[u8] = b"the old picture";

#[test]
fn ctrl_c_while_rendering_saves_what_there_is() {
    let mut cases = Vec::new();
    for (name, args, code) in [
        (
            "render",
            &["render", "a.pov", "-o", "out.png", "--size", "80x60", "--antialias", "off", "--progress", "json", "--backend", "cpu"][..],
            130,
        ),
        ("povray", &["povray", "+Ia.pov", "+Oout.png", "+W80", "+H60", "+GAall.txt", "Backend=cpu"][..], 2),
    ] {
        let folder = Folder::new();
        let scene = format!("{SLOW} #fopen F \"read.txt\" write #write (F, \"done\") #fclose F");
        folder.write("a.pov", scene);
        let child = folder.start("", args);
        wait_for(&folder.path("read.txt"));
        // The upper half of the picture needs a moment, the lower one forever.
        std::thread::sleep(Duration::from_millis(1500));
        signal(&child, "INT");
        let ended = finish(child);
        let picture = image::open(folder.path("out.png")).map(|i| (i.width(), i.height()));
        assert_eq!(picture.ok(), Some((80, 60)), "{name}: the picture is saved: {}", ended.said);
        assert!(ended.seconds < 30.0, "{name} took {} s to stop", ended.seconds);
        cases.push(Case(name, ended, if code == 130 { &[130] } else { &[2] }, "interrupted"));
    }
    judge(&cases);
}

#[test]
fn ctrl_c_while_reading_ends_at_once_and_leaves_the_old_picture() {
    for (args, code) in [(&["render", "a.pov", "-o", "out.png"][..], 130), (&["povray", "+Ia.pov", "+Oout.png"][..], 2)] {
        let folder = Folder::new();
        folder.write("a.pov", "#fopen F \"read.txt\" write #write (F, \"done\") #fclose F #while (1) #end").write("out.png", OLD);
        let child = folder.start("", args);
        wait_for(&folder.path("read.txt"));
        signal(&child, "INT");
        let ended = finish(child);
        assert_eq!(ended.code, Some(code), "{args:?}: {}", ended.said);
        assert_eq!(std::fs::read(folder.path("out.png")).expect("the old picture"), OLD);
    }
}

#[test]
fn a_kill_at_any_moment_leaves_the_old_picture_or_a_whole_new_one() {
    let folder = Folder::new();
    folder.write("a.pov", "#version 3.7; camera { location -3*z } sphere { 0, 1 pigment { granite } finish { ambient 1 } }");
    let args = [
        "render",
        "a.pov",
        "-o",
        "out.png",
        "--size",
        "700x500",
        "--bits",
        "16",
        "--antialias",
        "off",
        "--progress",
        "none",
        "--backend",
        "cpu",
    ];
    let whole = finish(folder.start("", &args));
    assert_eq!(whole.code, Some(0), "{}", whole.said);
    let new = std::fs::read(folder.path("out.png")).expect("a picture");
    let mut n_killed = 0;
    for k in 0..12 {
        folder.write("out.png", OLD);
        let child = folder.start("", &args);
        // Most of the moments lie near the end, where the file is written.
        std::thread::sleep(Duration::from_secs_f64(whole.seconds * (0.7 + 0.03 * f64::from(k))));
        signal(&child, "KILL");
        n_killed += u32::from(finish(child).code.is_none());
        let left = std::fs::read(folder.path("out.png")).expect("a picture");
        assert!(left == OLD || left == new, "neither the old picture nor the new one, but {} bytes", left.len());
    }
    assert!(n_killed > 0, "every run had ended already");
}
