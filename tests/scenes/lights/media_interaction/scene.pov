// Lights that do not reach media.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
light_source { <-4, 4, -3> rgb 1 media_interaction off }
light_source { <4, 4, -3> rgb <0.4, 0.5, 1> }
sphere { 0, 1 pigment { rgbt 1 } hollow interior { media { scattering { 1, 0.8 } intervals 1 samples 8 } } }
