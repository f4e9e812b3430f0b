// Photons by count, their radius found by itself, several targets and multipliers.
#version 3.7;
global_settings { assumed_gamma 1.0 photons { count 30000 } }
camera { location <0, 4, -6> look_at <0, -0.2, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { rgb <0.9, 0.85, 0.8> } finish { ambient 0.05 diffuse 0.7 } }
light_source { <3, 8, -2> rgb 0.9 }
light_source { <-4, 6, -3> rgb <0.4, 0.3, 0.2> }
sphere { <-1.1, 0, 0>, 0.8 pigment { rgbf 0.95 } finish { ambient 0 diffuse 0 reflection 0.1 } interior { ior 1.4 } photons { target 0.7 refraction on reflection on } }
box { <0.6, -1, 0>, <1.8, 0.4, 0.2> rotate -y*30 pigment { rgb 0.2 } finish { reflection 0.8 } photons { target reflection on collect off } }
