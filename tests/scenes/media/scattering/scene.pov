// Two kinds of scattering in one container, with a spotlight.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
light_source { <3, 5, -3> rgb 1 spotlight point_at 0 radius 8 falloff 14 }
box { -0.9, 0.9 hollow pigment { rgbt 1 } interior { media { scattering { 5, 0.5 eccentricity 0.3 extinction 0.8 } intervals 2 samples 6 } } }
