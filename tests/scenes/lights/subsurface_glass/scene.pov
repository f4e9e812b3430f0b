// In glass, seen in a mirror, and lit from inside by a lamp in a body without shadow.
#version 3.7;
global_settings { assumed_gamma 1.0 mm_per_unit 10 subsurface { samples 20, 5 } }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
sphere { <-0.6, -0.1, 0>, 0.4 pigment { rgb <0.9, 0.7, 0.6> } finish { ambient 0.05 subsurface { translucency 0.5 } } interior { ior 1.6 } }
sphere { <-0.6, -0.1, 0>, 0.6 pigment { rgbt 1 } finish { reflection 0.1 } interior { ior 1.3 } }
sphere { <0.8, -0.2, 0.2>, 0.5 pigment { rgb <0.6, 0.8, 0.9> } finish { ambient 0.05 subsurface { translucency 0.5 } } interior { ior 1.4 } no_shadow }
light_source { <0.8, -0.2, 0.2> rgb 0.5 }
box { <-2, -1, 1.5>, <2, 1.5, 1.6> pigment { rgb 0 } finish { ambient 0 diffuse 0 reflection 0.8 } }
