// Adaptive media with aa_level and aa_threshold.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
sphere { 0, 1 pigment { rgbt 1 } hollow interior { media { method 3 emission 1 density { boxed color_map { [0 rgb 0] [0.3 rgb 0] [0.3 rgb <0.8, 0.5, 0.3>] } } intervals 1 samples 4 aa_level 3 aa_threshold 0.05 } } }
box { <1.1, -1, 0.5>, <1.6, 0.4, 1> pigment { rgb <0.8, 0.25, 0.2> } finish { phong 0.6 phong_size 60 } }
