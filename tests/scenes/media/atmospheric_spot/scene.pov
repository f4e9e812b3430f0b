// A spotlight's cone in the atmosphere.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
plane { y, -1 hollow pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
light_source { <-2, 3, -1> rgb 2 spotlight point_at <0.5, -1, 0.3> radius 10 falloff 15 }
media { scattering { 1, 0.12 } intervals 1 samples 24 }
sphere { <0.2, -0.4, 0>, 0.3 hollow pigment { rgb <0.8, 0.25, 0.2> } finish { phong 0.6 phong_size 60 } }
