//! Scenes that are wrong, endless, enormous, or mathematically senseless.

use super::run::{Ended, Folder};
use super::{Case, judge};

const VIEW: &str = "#version 3.7; camera { location -5*z } light_source { 5, 1 } ";

fn rendered(scene: impl AsRef<[u8]>) -> Ended {
    let folder = Folder::new();
    folder.write("a.pov", scene).render("a.pov", &["--max-steps", "1000000", "--max-memory", "1000"])
}

/// Scenes of `n` times `piece` after `head`.
fn many(head: &str, piece: &str, tail: &str, n: usize) -> Ended {
    rendered(format!("#version 3.7; {head}{}{tail}", piece.repeat(n)))
}

#[test]
fn nesting_without_end_is_refused() {
    for n in [10_000, 300_000] {
        let nested = "Too many nested";
        judge(&[
            Case("braces", many("", "{", "", n), &[3], "{ found instead"),
            Case("parentheses", many("#declare A = ", "(", "", n), &[3], nested),
            Case("vectors", many("#declare A = ", "<", "", n), &[3], nested),
            Case("signs", many("#declare A = ", "-", "1;", n), &[3], nested),
            Case("conditions", many("#declare A = (", "1?", "", n), &[3], nested),
            Case("unions", many("", "union{", "", n), &[3], nested),
            Case("textures", many("sphere{0,1 ", "texture{marble texture_map{[0 ", "", n), &[3], ""),
            Case("functions' parentheses", many("#declare F = function{", "(", "", n), &[3], nested),
            Case("strings", many("#debug ", "concat(", "", n), &[3], nested),
            Case("#if", many("", "#if(1)\n", "", n), &[3], nested),
            Case("#if not taken", many("", "#if(0)\n", "", n), &[3], "#end expected"),
            Case("#switch", many("", "#switch(1)\n", "", n), &[3], "#case"),
            Case("#macro", many("", "#macro A()\n", "", n), &[3], "#end expected"),
            Case("comments", many("", "/*", "", n), &[3], "closing comment"),
        ]);
    }
}

#[test]
fn long_scenes_are_read_to_their_end() {
    let n = 100_000;
    judge(&[
        Case("a sum", many("#declare A = 1", "+1", ";", n), &[0], ""),
        Case("a function", many("#declare F = function { x", "+x", " }", n), &[3], "Function too long"),
        Case("layers", many("sphere { 0, 1 ", "texture { pigment { rgbt 0.5 } }", "}", n), &[3], "Too many layers"),
        Case("spheres", many(VIEW, "sphere{0,1}", "", n), &[0], ""),
        Case("transforms", many("sphere { 0, 1 ", "rotate x ", "}", n), &[0], ""),
        Case("a difference", many("difference { ", "sphere { 0, 1 }", "}", 10_000), &[0, 3], ""),
        Case("clips", many("sphere { 0, 1 ", "clipped_by { plane { y, 0 } }", "}", 10_000), &[0, 3], ""),
        Case("warnings", many("", "#warning \"\\u001b[2J\"", "", n), &[0], ""),
    ]);
}

#[test]
fn loops_and_recursion_without_end_are_refused() {
    let endless = "does not end";
    judge(&[
        Case("#while", rendered("#while (1) #end"), &[3], endless),
        Case("#for", rendered("#for (I, 0, 1, 1e-10) #end"), &[3], endless),
        Case(
            "#while of includes",
            Folder::new()
                .write("a.inc", "")
                .write("a.pov", "#while (1) #include \"a.inc\" #end")
                .render("a.pov", &["--max-steps", "20000"]),
            &[3],
            endless,
        ),
        Case("a macro of itself", rendered("#macro A() A() #end A()"), &[3], "Too many nested"),
        Case("macros of each other", rendered("#macro A() B() #end #macro B() A() #end A()"), &[3], "Too many nested"),
        Case("a file of itself", Folder::new().write("a.pov", "#include \"a.pov\"").render("a.pov", &[]), &[3], "Too many nested include"),
        Case("#while of warnings", rendered("#while (1) #warning \"x\" #end"), &[3], endless),
        Case(
            "functions of functions",
            rendered(
                "#declare F = function(x) { x } #while (1) #declare G = function(x) { F(F(x) + F(x)) } #undef F #declare F = function(x) { G(x) + G(x) } #undef G #end",
            ),
            &[3],
            "takes too long",
        ),
    ]);
}

#[test]
fn memory_without_end_is_refused() {
    let fit = "does not fit";
    judge(&[
        Case("objects", rendered("#while (1) sphere { 0, 1 } #end"), &[3], ""),
        Case(
            "objects of objects",
            rendered("#declare A = sphere { 0, 1 } #while (1) #declare A = union { object { A } object { A } }; #end"),
            &[3],
            "",
        ),
        Case(
            "empty unions doubled",
            rendered(
                "#declare A = union { } #for (I, 1, 40) #declare A = union { object { A } object { A translate x } } #end object { A }",
            ),
            &[3],
            "objects inside objects",
        ),
        Case(
            "unions doubled",
            rendered(
                "#declare A = sphere { 0, 1 } #for (I, 1, 40) #declare A = union { object { A } object { A translate x } } #end object { A }",
            ),
            &[3],
            fit,
        ),
        Case(
            "differences doubled",
            rendered(
                "#declare A = sphere { 0, 1 } #for (I, 1, 40) #declare A = difference { object { A } object { A translate x } } #end object { A }",
            ),
            &[3],
            fit,
        ),
        Case("a string doubled", rendered("#declare S = \"a\"; #while (1) #declare S = concat(S, S); #end"), &[3], "String too long"),
        Case(
            "strings",
            rendered(
                "#declare S = \"abcd\"; #for (I, 1, 18) #declare S = concat(S, S) #end #declare L = array[100000] #for (I, 0, 99999) #declare L[I] = concat(S, str(I, 0, 0)); #end",
            ),
            &[3],
            fit,
        ),
        Case("arrays", rendered("#declare L = array[1000]; #for (I, 0, 999) #declare L[I] = array[1000000]; #end"), &[3], fit),
        Case(
            "arrays copied",
            rendered(
                "#declare A = array[20000000]; #declare A[0] = 1; #declare B = A; #declare B[0] = 2; #declare C = A; #declare C[0] = 3; #declare D = C; #declare D[1] = 1;",
            ),
            &[3],
            fit,
        ),
        Case(
            "arrays of arrays",
            rendered("#declare A = array[1]; #declare A[0] = 1; #while (1) #declare B = array[2]; #declare B[0] = A; #declare A = B; #end"),
            &[3],
            "made of each other",
        ),
        Case(
            "names",
            rendered(format!(
                "{}#while (1) #declare A = 1; #end",
                (0..100_000).map(|i| format!("#declare N{i} = {i};")).collect::<String>()
            )),
            &[3],
            "does not end",
        ),
        Case(
            "layers doubled",
            rendered("#declare T = texture { pigment { rgbt 0.5 } } #while (1) #declare T = texture { T } texture { T } #end"),
            &[3],
            "Too many layers",
        ),
        Case(
            "pigments of pigments",
            rendered("#declare P = pigment { rgb 1 } #while (1) #declare P = pigment { checker pigment { P } pigment { P } } #end"),
            &[3],
            "made of each other",
        ),
        Case("#debug", rendered("#while (1) #debug concat(str(1, 200, 0), \"\\n\") #end"), &[3], ""),
        Case("a huge array", rendered("#declare A = array[2147483647];"), &[3], "too large"),
        Case("a huge array of two dimensions", rendered("#declare A = array[1e5][1e5];"), &[3], "too large"),
        Case("an array of infinite size", rendered("#declare A = array[1/0];"), &[3], "too large"),
        Case("a huge function image", rendered("sphere { 0, 1 pigment { image_map { function 1e9, 1e9 { x } } } }"), &[3], "Illegal size"),
    ]);
}

#[test]
fn work_without_end_is_refused() {
    let huge = "2000000000";
    let scene = |body: &str| rendered(format!("{VIEW}{}", body.replace("HUGE", huge)));
    judge(&[
        Case("blur_samples", rendered("camera { location -5*z aperture 1 focal_point 0 blur_samples 2000000000 }"), &[3], "limit"),
        Case("radiosity count", scene("global_settings { radiosity { count HUGE } }"), &[3], "out of range"),
        Case("radiosity recursion_limit", scene("global_settings { radiosity { recursion_limit HUGE } }"), &[3], "out of range"),
        Case("area light", scene("light_source { 5, 1 area_light x, y, HUGE, HUGE }"), &[3], "limit"),
        Case("media samples", scene("media { emission 1 samples HUGE }"), &[3], "limit"),
        Case("media intervals", scene("media { emission 1 intervals HUGE }"), &[3], "limit"),
        Case("dispersion_samples", scene("sphere { 0, 1 interior { dispersion_samples HUGE } }"), &[3], "limit"),
        Case("mandel", scene("plane { z, 1 pigment { mandel HUGE } }"), &[3], "limit"),
        Case("number_of_waves", scene("global_settings { number_of_waves HUGE }"), &[3], "limit"),
        Case("julia_fractal", scene("julia_fractal { 0.1 max_iteration HUGE }"), &[3], "limit"),
        Case("max_trace_level", scene("global_settings { max_trace_level HUGE } plane { z, 1 finish { reflection 1 } }"), &[0], ""),
        Case("octaves", scene("plane { z, 1 pigment { bozo turbulence 1 octaves HUGE } }"), &[0], ""),
        Case("mesh2 vertices", scene("mesh2 { vertex_vectors { HUGE, 0, x, y } face_indices { 1, 0 } }"), &[3], "number of items"),
    ]);
}

/// Numbers out of every range, in every object: an error with a place or a picture, never a breakdown.
#[test]
fn senseless_geometry_is_survived() {
    const OBJECTS: &[&str] = &[
        "sphere { N, N }",
        "box { -N, N }",
        "cylinder { 0, N*x, N }",
        "cone { 0, N, N*y, 0 }",
        "torus { N, N }",
        "plane { N*y, N }",
        "disc { N, y, N, 0 }",
        "triangle { N, N*x, N*y }",
        "smooth_triangle { 0, N, x, N*z, y, 0 }",
        "superellipsoid { <N, N> }",
        "sphere { 0, 1 scale N }",
        "sphere { 0, 1 rotate N }",
        "sphere { 0, 1 translate N }",
        "sphere { 0, 1 matrix <N,N,N,N,N,N,N,N,N,N,N,N> }",
        "prism { 0, N, 4, <0,0>, <N,0>, <0,N>, <0,0> }",
        "lathe { 3, <0,0>, <N,N>, <0,N> }",
        "sor { 4, <N,0>, <N,1>, <N,2>, <N,3> }",
        "polygon { 4, 0, N*x, N*y, 0 }",
        "blob { threshold N sphere { 0, N, N } }",
        "quadric { N, N, N, N }",
        "poly { 2, <N,N,N,N,N,N,N,N,N,N> }",
        "quartic { <N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N,N> }",
        "height_field { function 2, 2 { N } }",
        "sphere_sweep { linear_spline 2, 0, N, N*x, 1 }",
        "isosurface { function { x*x - N } max_gradient N }",
        "parametric { function { u*N }, function { v }, function { N } 0, 1 }",
        "julia_fractal { N }",
        "ovus { N, N }",
        "bicubic_patch { type 1 flatness N u_steps 2 v_steps 2, 0, x, 2*x, 3*x, y, N, y, y, z, z, N, z, 0, 0, 0, N }",
        "mesh { triangle { N, x, y } triangle { 0, N*x, N*y } }",
        "mesh2 { vertex_vectors { 3, N, x, y } face_indices { 1, <0,1,2> } }",
        "sphere { 0, 1 pigment { bozo turbulence N scale N } }",
        "sphere { 0, 1 normal { bumps N scale N } }",
        "sphere { 0, 1 finish { phong N phong_size N reflection N } }",
        "sphere { 0, 1 pigment { rgbt N } interior { ior N fade_distance N fade_power N } }",
        "light_source { N, N spotlight radius N falloff N tightness N }",
        "sphere { 0, 1 hollow pigment { rgbt 1 } interior { media { emission N density { rgb N } } } }",
        "fog { distance N fog_type 2 fog_alt N }",
        "camera { location N direction N right N up N angle N look_at N }",
        "sphere { 0, 1 no_shadow clipped_by { plane { N*x, N } } }",
        "rainbow { angle N width N distance N direction N color_map { [N rgb N] } }",
        "#declare A = sin(N) + pow(N, N) + mod(1, N) + N/N;",
        "sphere { 0, 1 pigment { gradient N*x color_map { [N rgb N] [N rgb 0] } } }",
        "sphere { 0, 1 pigment { crackle metric N form N } }",
        "#declare S = spline { cubic_spline N, N, 0, 1 } sphere { S(N), 1 }",
    ];
    let mut cases = Vec::new();
    for n in ["0", "-1", "1e308", "-1e308", "1e-320", "(1/0)", "(0*(1/0))"] {
        for o in OBJECTS {
            let scene = format!("{VIEW}{}", o.replace('N', n));
            cases.push((format!("{o} with {n}"), rendered(scene)));
        }
    }
    let cases: Vec<Case> = cases
        .iter_mut()
        .map(|(name, ended)| {
            let taken = std::mem::replace(ended, Ended { code: None, said: String::new(), peak_mib: 0, seconds: 0.0 });
            Case(name.as_str(), taken, &[0, 3][..], "")
        })
        .collect();
    judge(&cases);
}

#[test]
fn indices_out_of_range_are_refused() {
    let mesh = |list: &str| rendered(format!("mesh2 {{ vertex_vectors {{ 3, 0, x, y }} {list} }}"));
    let range = "out of range";
    judge(&[
        Case("a face too far", mesh("face_indices { 1, <0,1,3> }"), &[3], range),
        Case("a negative face", mesh("face_indices { 1, <0,1,-1> }"), &[3], range),
        Case("an infinite face", mesh("face_indices { 1, <0,1,1/0> }"), &[3], range),
        Case("a texture too far", mesh("texture_list { 1, texture {} } face_indices { 1, <0,1,2>, 5 }"), &[3], ""),
        Case("a normal too far", mesh("normal_vectors { 1, z } face_indices { 1, <0,1,2> } normal_indices { 1, <0,0,9> }"), &[3], ""),
        Case("a uv too far", mesh("uv_vectors { 1, 0 } face_indices { 1, <0,1,2> } uv_indices { 1, <0,0,9> }"), &[3], ""),
        Case("an array element too far", rendered("#declare A = array[2]; #declare B = A[2];"), &[3], "out of range"),
        Case("a negative element", rendered("#declare A = array[2]; #declare B = A[-2];"), &[3], "Negative subscript"),
        Case("an element that is no number", rendered("#declare A = array[2]; #declare B = A[0*(1/0)];"), &[3], ""),
        Case("a character too far", rendered("#debug chr(1e9)"), &[3], "cannot be used"),
        Case("substr too far", rendered("#debug substr(\"abc\", 2, 9)"), &[3], "substr"),
        Case("division by zero", rendered(format!("{VIEW} sphere {{ 0, 1/0 }}")), &[0, 3], ""),
    ]);
}

#[test]
fn deep_textures_are_rendered() {
    // 20 deep by declaration; literal ones would be as deep in braces.
    let deep = |first: &str, next: &str, last: &str| {
        rendered(format!("{VIEW} #declare T = {first} #for (I, 1, 20) #declare T = {next} #end sphere {{ 0, 1 {last} }}"))
    };
    judge(&[
        Case(
            "texture maps",
            deep("texture { pigment { rgb 1 } }", "texture { marble texture_map { [0 T] [1 T] } }", "texture { T }"),
            &[0],
            "",
        ),
        Case("pigment maps", deep("pigment { rgb 1 }", "pigment { bozo pigment_map { [0 T] [1 T] } }", "pigment { T }"), &[0], ""),
        Case("averages", deep("pigment { rgb 1 }", "pigment { average pigment_map { [1 T] } }", "pigment { T }"), &[0], ""),
        Case(
            "normal maps",
            deep("normal { bumps }", "normal { bozo normal_map { [0 T] [1 T] } }", "pigment { rgb 1 } normal { T }"),
            &[0],
            "",
        ),
    ]);
}
