//! Bad and hostile input through the command line: one clear error, the right exit code, bounded time and memory, and no old
//! picture destroyed.

mod files;
mod interrupts;
mod language;
mod run;
mod scenes;

use run::{Ended, Folder};

/// A case: its name, how it ended, the exit codes that are right, what the error must say.
struct Case<'c>(&'c str, Ended, &'c [i32], &'c str);

/// Most memory of any case, in MiB; the limit that the memory cases are given is 1000.
const MEMORY_MIB: u64 = 1300;

/// Fails with all that is wrong; with --nocapture a table of all cases is printed.
fn judge(cases: &[Case]) {
    let mut wrong = Vec::new();
    for Case(name, ended, codes, says) in cases {
        let code = ended.code.unwrap_or(-1);
        let error = ended.errors().first().map_or(String::new(), |e| e.chars().take(110).collect());
        println!("| {name} | {code} | {:.2} s | {} MiB | {error} |", ended.seconds, ended.peak_mib);
        let fault = ended
            .faults()
            .or_else(|| (!codes.contains(&code)).then(|| format!("exit code {code}, not {codes:?}: {error}")))
            .or_else(|| (code != 0 && !ended.said.contains(says)).then(|| format!("it says {error:?}, not {says:?}")))
            .or_else(|| (ended.peak_mib > MEMORY_MIB).then(|| format!("{} MiB of memory", ended.peak_mib)));
        wrong.extend(fault.map(|f| format!("{name}: {f}")));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn nonsense_on_the_command_line_is_a_usage_error() {
    let folder = Folder::new();
    folder.write("a.pov", "camera { location -3*z } sphere { 0, 1 }");
    let nonsense: Vec<String> = (0..300).map(|i| format!("+{}{i}{}", ["ZZ", "&", "XQ", "-", "A=", "é"][i % 6], "x".repeat(i))).collect();
    let words: Vec<&str> = ["povray", "+Ia.pov"].into_iter().chain(nonsense.iter().map(String::as_str)).collect();
    let render: Vec<&str> = ["render", "a.pov"].into_iter().chain(nonsense.iter().map(String::as_str)).collect();
    let long = "x".repeat(100_000);
    judge(&[
        Case("300 words of nonsense (povray)", folder.run(&words), &[1], ""),
        Case("+W0", folder.run(&["povray", "+Ia.pov", "+W0"]), &[1], "0 by"),
        Case("+W100000000", folder.run(&["povray", "+Ia.pov", "+W100000000"]), &[1], "100000000 by"),
        Case("+W99999999999999999999", folder.run(&["povray", "+Ia.pov", "+W99999999999999999999"]), &[1], "whole number"),
        Case("a word of 100,000 letters", folder.run(&["povray", "+Ia.pov", &long]), &[1], ""),
        Case("2 billion frames", folder.run(&["povray", "+Ia.pov", "+KFI1", "+KFF2000000000"]), &[1], "frames"),
        Case("--size 0x0", folder.run(&["render", "a.pov", "-o", "o.png", "--size", "0x0"]), &[2], "0 by 0"),
        Case("--size twice", told_by_clap(folder.render("a.pov", &["--size", "8x6"])), &[2], "multiple times"),
        Case("--samples backwards", told_by_clap(folder.run(&["render", "a.pov", "--samples", "9..2"])), &[2], "A not above B"),
        Case("--size 100000000x1", folder.run(&["render", "a.pov", "-o", "o.png", "--size", "100000000x1"]), &[2], "100000000 by 1"),
        Case(
            "a picture larger than memory",
            folder.run(&["render", "a.pov", "-o", "o.png", "--size", "40000x40000"]),
            &[2],
            "does not fit",
        ),
        Case("no extension", folder.run(&["render", "a.pov", "-o", "o"]), &[2], "must end in"),
    ]);
    let usage = told_by_clap(folder.run(&render));
    judge(&[Case("300 words of nonsense (render)", usage, &[2], "")]);
}

/// clap's message has more than one line, its first is the error.
fn told_by_clap(mut ended: Ended) -> Ended {
    let first = ended.said.lines().find(|l| l.starts_with("error: ")).unwrap_or_default().to_owned();
    ended.said = first;
    ended
}

#[test]
fn ini_files_without_end_are_refused() {
    let folder = Folder::new();
    folder.write("a.ini", "Include_INI=a.ini\n").write("garbage.ini", [0xff, 0xfe, 0, 1, 2, b'=', b'\n', b'[', b'\n', b'+']);
    folder.write("twice.ini", "Include_INI=b.ini\n".repeat(2000)).write("b.ini", "");
    judge(&[
        Case("an INI file of itself", folder.run(&["povray", "a.ini"]), &[1], "nested more than 16"),
        Case("2000 INI files", folder.run(&["povray", "twice.ini"]), &[1], "more than 1000"),
        Case("an INI file of garbage", folder.run(&["povray", "garbage.ini"]), &[1], "garbage.ini"),
        Case("no such INI file", folder.run(&["povray", "none.ini"]), &[1], "none.ini"),
        Case("an INI file of itself (render)", folder.run(&["render", "a.ini"]), &[2], "nested more than 16"),
    ]);
}

#[test]
fn a_wrong_run_is_noticed() {
    let ended = |code, said: &str| Ended { code, said: said.into(), peak_mib: 0, seconds: 0.0 };
    assert!(ended(Some(3), "error: one\n").faults().is_none());
    assert!(ended(Some(3), "error: one\nerror: two\n").faults().is_some());
    assert!(ended(Some(3), "").faults().is_some());
    assert!(ended(Some(1), "thread panicked at\nerror: one\n").faults().is_some());
    assert!(ended(None, "error: one\n").faults().is_some());
    assert!(ended(Some(0), "\u{1b}[2J").faults().is_some());
}
