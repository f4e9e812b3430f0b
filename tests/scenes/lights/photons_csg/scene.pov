// Switches of a difference over those of its parts; parts of a union are targets one by one.
#version 3.7;
global_settings { assumed_gamma 1.0 photons { spacing 0.04 radius 0.2 } }
camera { location <0, 4, -6> look_at <0, -0.2, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { rgb <0.9, 0.85, 0.8> } finish { ambient 0.05 diffuse 0.7 } }
light_source { <3, 8, -2> rgb 0.9 }
difference { sphere { <-1.1, 0, 0>, 0.9 } box { <-1.2, -0.2, -2>, <0, 2, 0.2> photons { refraction off } } pigment { rgbf 1 } finish { ambient 0 diffuse 0 } interior { ior 1.5 } photons { target refraction on } }
union { sphere { <1, -0.2, -0.5>, 0.6 } sphere { <1.4, -0.2, 0.9>, 0.6 photons { target 3 reflection off } } pigment { rgbf 0.9 } finish { ambient 0 diffuse 0 } interior { ior 1.3 } photons { target } photons { refraction on } }
