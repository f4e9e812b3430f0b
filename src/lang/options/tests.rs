//! Options as POV-Ray takes them: every expectation was printed by the installed program.

use super::*;
use crate::lang::Declared;
use crate::world::WorldError;
use std::path::Path;
use std::sync::Arc;

/// INI files by name.
struct Files(&'static [(&'static str, &'static str)]);

impl World for Files {
    fn find(&self, name: &str, extensions: &[&str]) -> Option<PathBuf> {
        let has = |n: &str| self.0.iter().any(|f| f.0 == n);
        extensions.iter().map(|e| format!("{name}{e}")).chain([name.to_owned()]).find(|n| has(n)).map(PathBuf::from)
    }
    fn read(&self, path: &Path) -> Result<Arc<[u8]>, WorldError> {
        let name = path.to_string_lossy();
        let text = self.0.iter().find(|f| f.0 == name).map(|f| f.1);
        text.map(|t| t.as_bytes().into()).ok_or_else(|| WorldError::NotFound(name.into_owned()))
    }
    fn write(&self, path: &Path, _bytes: &[u8], _append: bool) -> Result<(), WorldError> {
        Err(WorldError::NotFound(path.display().to_string()))
    }
    fn now_seconds(&self) -> f64 {
        0.0
    }
}

fn read(words: &[&str], files: &'static [(&'static str, &'static str)]) -> Result<PovOptions, OptionError> {
    let mut o = PovOptions::default();
    words.iter().try_for_each(|w| o.word(w, "command line", &Files(files), 0))?;
    Ok(o)
}

fn options(words: &[&str]) -> PovOptions {
    read(words, &[]).expect("options that POV-Ray takes")
}

fn frames_of(o: &PovOptions) -> Vec<Frame> {
    frames(o).expect("a short animation")
}

#[test]
fn an_animation_without_end_is_refused() {
    assert!(matches!(frames(&options(&["+KFI1", "+KFF2147483647"])), Err(OptionError::TooManyFrames(1_000_000))));
    assert_eq!(frames_of(&options(&["+KFI1", "+KFF2147483647", "+SF5", "+EF6"])).len(), 2);
}

#[test]
fn switches_take_glued_values_in_any_case_and_with_either_sign() {
    let o = options(&["+Iscene.pov", "-w320", "+H240", "+Q7", "+wt3", "+FN16", "-UA", "+r5", "+AM2", "+BS8", "+HR"]);
    assert!(o.high_reproducibility && !options(&["High_Reproducibility=off"]).high_reproducibility);
    assert_eq!((o.width, o.height, o.quality, o.threads, o.bits_per_color), (320, 240, 7, 3, 16));
    assert_eq!(
        (o.input.as_deref(), o.output_alpha, o.antialias_depth, o.sampling_method, o.block_size),
        (Some("scene.pov"), false, 5, 2, 8)
    );
}

#[test]
fn antialiasing_thresholds_start_with_a_zero() {
    let o = options(&["+A0.25"]);
    assert!(o.antialias);
    assert_eq!(o.antialias_threshold, 0.25);
    assert!(options(&["+A"]).antialias && !options(&["+A0.3", "-A"]).antialias);
    for bad in ["+A.3", "+A1", "+A0", "+A1.5"] {
        assert!(read(&[bad], &[]).is_err(), "{bad} is an error in POV-Ray");
    }
}

#[test]
fn the_longest_switch_that_fits_wins() {
    let o = options(&["+KFI2", "+KFF9", "+KI1.5", "+KF2.5", "+KC", "+SF3", "+EF7", "+STP2"]);
    assert_eq!((o.initial_frame, o.final_frame, o.initial_clock, o.final_clock), (2, 9, 1.5, 2.5));
    assert!(o.cyclic);
    assert_eq!((o.subset_start, o.subset_end, o.frame_step), (3.0, 7.0, 2));
    let o = options(&["+SC3", "+EC0.5", "+K0.25", "+J0.5", "+MV3.5", "+HIhead.inc"]);
    assert_eq!((o.start_column, o.end_column, o.clock, o.clock_on), (Some(3.0), Some(0.5), 0.25, true));
    assert_eq!((o.jitter_amount, o.version, o.header.as_deref()), (0.5, Some(350), Some("head.inc")));
}

#[test]
fn what_povray_refuses_is_refused() {
    for bad in ["+QQ", "+Fx", "+Wx", "Foo=1", "+W", "nosuchfile", "+AM", "Buffer_Size=3"] {
        assert!(read(&[bad], &[]).is_err(), "{bad}");
    }
    let message = read(&["Widht=3"], &[]).expect_err("an unknown key").to_string();
    assert!(message.contains("did you mean 'width'"), "{message}");
}

#[test]
fn output_types_carry_bits_and_grey() {
    let o = options(&["+FP12g"]);
    assert_eq!((o.output_type, o.bits_per_color, o.grayscale), (OutputType::Ppm, 12, true));
    assert_eq!(options(&["+FC"]).output_type, OutputType::TargaRle);
    assert!(!options(&["-F"]).output_to_file);
    assert_eq!(options(&["+FN3"]).bits_per_color, 5, "bits are clipped to 5..16");
}

#[test]
fn ini_files_have_comments_sections_quotes_and_switches() {
    const INI: &[(&str, &str)] = &[(
        "a.ini",
        "; comment\nWidth = 100 # columns\nInput_File_Name=\"my scene.pov\"\n+H50 -A\nLibrary_Path=\"p1\", p2\n[Big]\nWidth=400\n[small]\nWidth=10 Height=5\n",
    )];
    let o = read(&["a.ini"], INI).expect("a good file");
    assert_eq!((o.width, o.height, o.input.as_deref()), (100, 50, Some("my scene.pov")));
    assert_eq!(o.library_paths, ["p1", "p2"]);
    assert_eq!(read(&["a.ini[big]"], INI).expect("a section").width, 400);
    let small = read(&["a[SMALL]"], INI).expect("a section without the extension");
    assert_eq!((small.width, small.height), (10, 50), "a second key on a line is ignored");
    assert_eq!(read(&["a.ini[none]"], INI).expect("no such section is no error").width, 100);
}

#[test]
fn later_settings_win_except_declared_names() {
    let o = options(&["+W10", "+W20", "Declare=A=1.5", "Declare=A=7", "Declare=S=\"text\"", "Declare=B=word"]);
    assert_eq!(o.width, 20);
    let want = [("A", Declared::Float(1.5)), ("S", Declared::Text("text".into())), ("B", Declared::Float(0.0))];
    assert_eq!(o.declares, want.map(|(n, v)| (n.to_owned(), v)));
}

#[test]
fn ini_files_that_include_each_other_end_with_an_error() {
    const LOOP: &[(&str, &str)] = &[("a.ini", "Include_Ini=a.ini\n")];
    assert!(matches!(read(&["a.ini"], LOOP), Err(OptionError::TooDeep(_))));
}

#[test]
fn clocks_of_frames_are_povrays() {
    let clocks = |words: &[&str]| frames_of(&options(words)).iter().map(|f| (f.number, f.clock)).collect::<Vec<_>>();
    assert_eq!(clocks(&["+KFF3"]), [(1, 0.0), (2, 0.5), (3, 1.0)]);
    assert_eq!(clocks(&["+KFF5", "+KC"]).last(), Some(&(5, f64::from(0.8f32))));
    assert_eq!(frames_of(&options(&["+KFF5", "+KC"]))[0].variables[2], 6.0, "final_frame of a cyclic run reads one more");
    assert_eq!(clocks(&["+KFF4", "+SF0.5"]).first().map(|c| c.0), Some(2));
    assert!(frames_of(&options(&["+KFF1"]))[0].clock.is_nan(), "POV-Ray divides by zero");
    assert_eq!(frames_of(&options(&["+K0.5"])), [Frame { number: 0, clock: 0.5, clock_on: true, variables: [0.0; 6], digits: 0 }]);
}

#[test]
fn pictures_are_named_as_povray_names_them() {
    let name = |words: &[&str], input: &str| {
        let o = options(words);
        match o.output_for(Path::new(input), &frames_of(&o)[0]) {
            OutputName::File(p) => p.display().to_string(),
            other => format!("{other:?}"),
        }
    };
    assert_eq!(name(&[], "dir/a.b.pov"), "dir/a.b.png");
    assert_eq!(name(&["+Oq."], "a.pov"), "q.png");
    assert_eq!(name(&["+Oq.jpg"], "a.pov"), "q.jpg.png");
    assert_eq!(name(&["+Oout/"], "dir/a.pov"), "out/a.png");
    assert_eq!(name(&["+Ox.tga", "+FT"], "a.pov"), "x.tga");
    assert_eq!(name(&["+KFF9", "+KC"], "t.pov"), "t01.png");
    assert_eq!(name(&["+KFI0", "+KFF9", "+Oy.png"], "t.pov"), "y0.png");
    assert_eq!(name(&["+O-"], "t.pov"), "Stdout");
}

#[test]
fn options_that_change_nothing_are_told_once() {
    let o = options(&["+MB3", "+MB5", "+RS3", "-D", "-P"]);
    let keys: Vec<&str> = o.ignored.iter().map(|(k, _)| k.as_str()).collect();
    assert_eq!(keys, ["bounding_threshold", "render_block_step"], "there is no window to speak of");
}
