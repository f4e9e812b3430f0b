// Glass of blended and averaged textures: photons follow each.
#version 3.7;
global_settings { assumed_gamma 1.0 photons { spacing 0.05 radius 0.2 } }
camera { location <0, 4, -6> look_at <0, -0.2, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { rgb <0.9, 0.85, 0.8> } finish { ambient 0.05 diffuse 0.7 } }
light_source { <3, 8, -2> rgb 0.9 }
sphere { 0, 1 texture { gradient y texture_map { [0 pigment { rgbf <1, 0.6, 0.5, 0.9> } finish { diffuse 0 reflection 0.3 }] [1 pigment { rgbf <0.3, 0.6, 0.9, 0.9> } normal { bumps 0.3 scale 0.3 } finish { diffuse 0 reflection { 0, 0.8 } }] } scale 2 translate -1*y } interior { ior 1.5 } photons { target refraction on reflection on } }
