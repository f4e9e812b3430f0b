// bounds that cut: the box of the bounds is asked, but not for shapes that work their box out anew.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
#declare B = box { -0.25, 0.25 }
#declare F = texture { pigment { rgb <1, 0.5, 0.2> } finish { phong 0.5 } }
torus { 0.35, 0.15 bounded_by { B } texture { F } rotate x*-50 translate <-1, 0.6, 0.5> }
blob { threshold 0.5 sphere { 0, 0.6, 1 } bounded_by { B } texture { F } translate <0, 0.6, 0.5> }
superellipsoid { <0.4, 0.4> bounded_by { B scale 2 } texture { F } scale 0.4 translate <1, 0.6, 0.5> }
disc { 0, <0, 0.5, -1>, 0.45 bounded_by { B } texture { F } translate <-1, -0.4, 0> }
mesh { triangle { <-0.5, -0.5, 0>, <0.5, -0.5, 0>, <0, 0.5, 0> } bounded_by { B } texture { F } translate <0, -0.4, 0> }
