// A height field without its hierarchy.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
height_field { function 20, 20 { abs(sin(6*x + 4*y)) } hierarchy off translate <-0.5, 0, -0.5> scale <2.6, 0.8, 2.6> translate -1*y pigment { rgb <0.8, 0.65, 0.2> } }
