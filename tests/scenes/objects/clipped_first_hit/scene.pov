// Bodies of which a ray reports one hit alone show their far side where clipped_by takes the near one away.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
#declare Cut = plane { -z, 0.1 rotate 20*y }
blob { threshold 0.3 sphere { <-0.2, 0, 0>, 0.6, 1 } sphere { 0.3*x, 0.5, 1 } clipped_by { Cut } translate <-0.8, 0.75, 0> pigment { rgb <0.85, 0.4, 0.2> } }
superellipsoid { <0.8, 0.6> scale 0.5 rotate <20, 35, 0> clipped_by { Cut } translate <0.9, 0.7, 0> pigment { rgb <0.3, 0.5, 0.85> } }
julia_fractal { <-0.1, 0.8, -0.1, 0> quaternion sqr max_iteration 6 precision 40 scale 0.5 clipped_by { Cut } translate <-0.8, -0.4, 0> pigment { rgb <0.4, 0.75, 0.3> } }
height_field { function 24, 24 { 0.5 + 0.4*sin(x*11)*cos(y*9) } translate -0.5 rotate -60*x clipped_by { Cut } translate <0.8, -0.5, 0> pigment { rgb <0.85, 0.8, 0.6> } }
