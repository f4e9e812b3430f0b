// A sky that is turned, and its emission.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
sky_sphere { pigment { checker rgb <0.9, 0.4, 0.2> rgb <0.2, 0.3, 0.6> scale 0.25 } rotate <20, 30, 10> emission rgb <0.5, 1, 1> }
sphere { 0, 0.9 pigment { rgb 0.1 } finish { reflection 0.9 } }
