// Under layers, as a part of a texture map, with a pattern, bumps and partly clear pigments.
#version 3.7;
global_settings { assumed_gamma 1.0 mm_per_unit 10 subsurface { samples 20, 5 } }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
#declare Wax = texture { pigment { bozo color_map { [0 rgb <0.9, 0.3, 0.2>] [1 rgb 0.8] } scale 0.3 } normal { bumps 0.6 scale 0.2 } finish { ambient 0 specular 0.4 subsurface { translucency 0.5 } } }
sphere { <-0.8, 0.2, 0>, 0.6 texture { Wax } texture { pigment { rgbt <0.5, 1, 0.5, 0.6> } finish { ambient 0 diffuse 0.4 specular 0.3 } } interior { ior 1.4 } }
sphere { <0.6, 0.2, 0>, 0.6 texture { gradient x texture_map { [0.3 Wax] [0.7 pigment { rgb <0.3, 0.5, 1> } finish { ambient 0 }] } } interior { ior 1.4 } }
sphere { <0, -0.5, -0.9>, 0.4 pigment { rgbt <0.9, 0.7, 0.6, 0.4> } finish { ambient 0.05 subsurface { translucency 0.5 } } interior { ior 1.4 } }
