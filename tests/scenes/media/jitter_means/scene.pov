// Jittered samples of media that shine and scatter: means over many samples are compared.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { rgb <0.85, 0.82, 0.75> } finish { ambient 0.1 diffuse 0.7 } }
light_source { <4, 6, -5> rgb 0.9 }
sphere { -0.8*x, 0.9 hollow pigment { rgbt 1 } interior { media { method 3 emission 0.6 intervals 1 samples 3 jitter 1 density { spherical color_map { [0 rgb 0] [1 rgb <1, 0.5, 0.2>] } } } } }
sphere { 0.9*x, 0.8 hollow pigment { rgbt 1 } interior { media { method 3 scattering { 1, 0.6 } intervals 2 samples 3 jitter 0.7 density { gradient y color_map { [0 rgb 0] [0.5 rgb 1] [1 rgb 0] } } } } }
