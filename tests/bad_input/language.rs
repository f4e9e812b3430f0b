//! Scenes that POV-Ray 3.7 refuses in these words, and odd ones that it takes. Source: measured.

use super::Case;
use super::judge;
use super::run::{Ended, Folder};

fn rendered(scene: &str) -> Ended {
    let head = "#version 3.7; global_settings { assumed_gamma 1 } camera { location -5*z } light_source { 5, 1 } ";
    let ball = "sphere { 0, 1 pigment { rgb 1 } }";
    Folder::new().write("a.pov", format!("{head}{}", scene.replace("BALL", ball))).render("a.pov", &[])
}

#[test]
fn what_povray_refuses_is_refused_in_its_words() {
    let cases = [
        ("isosurface { function(a, b) { a + b } }", "Missing { after 'function', ( found instead"),
        ("sphere { 0, 1 pigment { function(x, y) { x } } }", "Missing { after 'function', ( found instead"),
        ("parametric { function(u, v) { u }, function { v }, function { u*v } <0, 0>, <1, 1> }", "Missing { after 'function'"),
        ("sphere { 0, 1 clipped_by { box { -1, 1 } } bounded_by { clipped_by } bounded_by { box { -1, 1 } } }", "Cannot add bounds after"),
        ("sphere { 0, 1 bounded_by { box { -1, 1 } } clipped_by { bounded_by } clipped_by { box { -1, 1 } } }", "Cannot add clips after"),
        ("sphere { 0, 1 pigment { slope 0 } }", "Zero length for both slope and gradient."),
        ("sphere { 0, 1 pigment { slope { 0, 0, 1 } } }", "Zero length for both slope and gradient."),
        ("sphere { 0, 1 pigment { rgb 1 rgb 0 } }", "No matching } in 'pigment', color keyword 'rgb' found instead"),
        ("#declare P = pigment { rgb 1 }; sphere { 0, 1 pigment { P translate x rgb 1 } }", "No matching } in 'pigment'"),
        ("camera { mesh_camera { 0 0 mesh { triangle { 0, x, y } } } }", "Rays per pixel may not be 0"),
        ("global_settings { photons { count 10 gather 50, 20 } }", "min_gather_count must be less than max_gather_count."),
        ("global_settings { photons { count 10 media -1 } }", "max media steps must be non-negative."),
        ("#declare A = array[2] { 1, 2 }; #declare B = A[-1];", "Negative subscript"),
        ("#declare A = array[2] { 1, 2 }; #declare B = A[-0.0000001];", "Negative subscript"),
        (
            "#declare F = function { pigment { rgb 1 } }; sphere { 0, 1 pigment { function { F(x, y, z) } } }",
            "Expected '.', } found instead",
        ),
        ("#declare F = function { transform { translate x } }; #declare G = function { F(x, y, z) };", "Expected '.'"),
        ("#declare S = spline { 0, x 1, y } #declare G = function { S(x) };", "Expected 'operand', spline identifier found instead"),
        ("#declare F = function { pattern { bozo } }; #declare G = function { F(x, y, z).red };", ". (period) found instead"),
        ("#declare F = function { internal(200) };", "Function 'internal(200)' does not exist."),
        ("#declare F = function { internal(-1) };", "Expected 'internal function identifier', - found instead"),
        ("sphere { 0, 1 split_union on }", "split_union found in non-union object."),
        ("#debug substr(\"abc\", 0, 5)", "Illegal parameters in substr."),
    ];
    let cases = cases.map(|(scene, says)| Case(scene, rendered(scene), &[3], says));
    judge(&cases);
}

#[test]
fn what_povray_takes_is_taken() {
    let cases = [
        "BALL #declare A = array[2] { 1, 2 }; #declare B = A[-0.000000000001];",
        "#declare P = pigment { rgb 1 }; sphere { 0, 1 pigment { P rgb 0 } }",
        "sphere { 0, 1 hollow pigment { rgbt 1 } interior { media { scattering { 1 } } } }",
        "sphere { 0, 1 pigment { rgb 1 quick_color } finish { ambient reflection } }",
        "sphere { 0, 1 pigment { function { u + v } } }",
        "#declare F = function(a) { x + y + z + a }; #if (F(2) != 2) #error \"coordinates that are no parameters are 0\" #end BALL",
        "#declare F = function(u, x) { x + 10*u + 100*v }; #if (F(2, 3) != 33) #error \"u and x are one name\" #end BALL",
        "#if (strcmp(substr(\"abc\", 0, 4), \"\") != 0) #error \"nothing stands at place 0\" #end BALL",
        "union { sphere { 0, 1 } sphere { x, 1 } split_union on pigment { rgb 1 } }",
        "#declare U = union { sphere { 0, 1 } sphere { x, 1 } }; object { U split_union off pigment { rgb 1 } }",
        "sphere { 0, 1 pigment { slope { 0 altitude y } } }",
    ];
    judge(&cases.map(|scene| Case(scene, rendered(scene), &[0], "")));
}

#[test]
fn what_povray_warns_of_is_told() {
    let cases = [
        ("#version 3.7; sphere { 0, 1 }", "assumed_gamma not specified in this scene of version 3.7"),
        ("#version 3.5; sphere { 0, 1 }", "assumed_gamma not specified: gamma correction is off"),
        ("#declare A = 1; #version 3.7; sphere { 0, 1 }", "other declarations preceding the first #version"),
        ("#version 3.1; sphere { 0, 1 }", "The scene ends as one of language version 3.1"),
        ("#version 3.7; background { rgb 1 }", "No objects in scene."),
        ("#version 3.7; triangle { 0, x, 2*x }", "Degenerate triangle. Please remove."),
        ("#version 3.7; smooth_triangle { 0, z, x, -z, y, z }", "Degenerate triangle. Please remove."),
        ("#version 3.7; sphere { 0, 1 bounded_by { box { -1, 1 } } }", "Unnecessary bounding object removed."),
        ("#version 3.7; union { sphere { 0, 1 } sphere { x, 1 } bounded_by { box { -1, 2 } } }", "CSG union unnecessarily bounded."),
        ("#version 3.7; camera { right x + 0.1*y } sphere { 0, 1 }", "Camera vectors are not perpendicular."),
        ("#version 3.7; declare A = 1; sphere { 0, 1 }", "'declare' should be changed to '#declare'"),
    ];
    let mut wrong = Vec::new();
    for (scene, says) in cases {
        let ended = Folder::new().write("a.pov", scene).render("a.pov", &[]);
        if ended.code != Some(0) || !ended.said.contains(says) {
            wrong.push(format!("{scene}: {:?} {}", ended.code, ended.said));
        }
    }
    let settings = "#version 3.7; global_settings { assumed_gamma 1 }";
    for rest in [
        "light_source { 0, 1 }",
        "camera { location <1, 2, 3> look_at 0 rotate 40 } difference { sphere { 0, 1 } box { 0, 1 } bounded_by { box { -1, 1 } } }",
        "merge { sphere { 0, 1 bounded_by { box { -1, 1 } } } sphere { x, 1 } } union { sphere { 0, 1 } box { 0, 1 } bounded_by { box { -1, 1 } } inverse }",
    ] {
        let ended = Folder::new().write("a.pov", format!("{settings} {rest}")).render("a.pov", &[]);
        if ended.said.contains("warning") {
            wrong.push(format!("{rest}: {}", ended.said));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
