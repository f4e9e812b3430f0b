// The caustic inside a metal ring.
#version 3.7;
global_settings { assumed_gamma 1.0 photons { spacing 0.03 radius 0.15 } }
camera { location <0, 4, -6> look_at <0, -0.2, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { rgb <0.9, 0.85, 0.8> } finish { ambient 0.05 diffuse 0.7 } }
light_source { <3, 8, -2> rgb 0.9 }
cylinder { <0, -1, 0>, <0, 0, 0>, 1.2 open pigment { rgb <0.8, 0.6, 0.3> } finish { ambient 0 diffuse 0.2 reflection { 0.8 metallic } } photons { target reflection on } }
