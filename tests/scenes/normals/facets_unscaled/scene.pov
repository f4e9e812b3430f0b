// Facets with no_bump_scale: the long normal of a scaled one is made unit all the same.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
sphere { <-0.75, 0.1, 0>, 0.8 pigment { rgb <0.85, 0.8, 0.7> } normal { facets coords 0.4 scale 0.5 no_bump_scale } finish { phong 0.4 } }
sphere { <0.85, 0.1, 0>, 0.8 pigment { rgb <0.6, 0.75, 0.85> } normal { facets coords 0.6 scale <0.8, 0.4, 0.3> no_bump_scale } }
