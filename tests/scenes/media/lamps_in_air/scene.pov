// An atmosphere that scatters the beams of a cone and a cylinder, absorbs, and is seen in a mirror and through a hollow body with its own medium.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
media { method 3 scattering { 2, rgb 0.12 extinction 0.5 } absorption rgb <0.01, 0.02, 0.03> intervals 3 samples 6 aa_level 3 ratio 0.8 }
plane { y, -1 pigment { rgb <0.85, 0.82, 0.75> } finish { ambient 0.1 diffuse 0.7 } }
plane { z, 3 hollow pigment { rgb 0.3 } finish { reflection 0.5 diffuse 0.4 } }
light_source { <2, 4, -2> rgb 1.5 spotlight point_at <-0.3, 0, 0> radius 8 falloff 14 }
light_source { <-2, 4, 0> rgb <0.5, 0.7, 1> cylinder point_at <-0.9, 0, 0.5> radius 0.3 falloff 0.5 }
light_source { <0, 5, -6> rgb 0.3 media_interaction off }
sphere { <-0.7, -0.2, 0>, 0.7 hollow pigment { rgbf <0.9, 0.8, 0.8, 0.8> } interior { media { emission <0.1, 0.3, 0.1> method 3 samples 5 } } }
box { <0.6, -1, -0.3>, <1.2, 0.4, 0.4> pigment { rgb <0.2, 0.35, 0.8> } }
