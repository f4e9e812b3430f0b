// Photons of parallel light that fades.
#version 3.7;
global_settings { assumed_gamma 1.0 photons { spacing 0.03 radius 0.2 } }
camera { location <0, 4, -6> look_at <0, -0.2, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { rgb <0.9, 0.85, 0.8> } finish { ambient 0.05 diffuse 0.7 } }
light_source { <3, 8, -2> rgb 1.2 parallel point_at <0.3, 0, 0> fade_distance 6 fade_power 1 }
sphere { 0, 1 pigment { rgbf <1, 0.98, 0.95, 0.9> } finish { ambient 0 diffuse 0.05 phong 0.4 } interior { ior 1.5 } photons { target refraction on } }
