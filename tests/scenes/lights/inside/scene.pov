// A lamp inside an open body.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
light_source { 0 rgb <1, 0.8, 0.5> fade_distance 1 fade_power 2 }
difference { sphere { 0, 0.9 } sphere { 0, 0.8 } box { <-0.3, 0.2, -2>, <0.3, 2, 2> } box { <0.2, -0.2, -2>, <2, 0.1, 2> } pigment { rgb <0.8, 0.65, 0.2> } }
