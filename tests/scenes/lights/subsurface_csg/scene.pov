// Bodies of several parts, with inner surfaces and without.
#version 3.7;
global_settings { assumed_gamma 1.0 mm_per_unit 10 subsurface { samples 20, 5 } }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
#declare Wax = texture { pigment { rgb <0.9, 0.7, 0.6> } finish { ambient 0 subsurface { translucency 2 } } }
union { sphere { <-0.3, 0, 0>, 0.4 } sphere { <0.2, 0, 0>, 0.4 } texture { Wax } interior { ior 1.4 } translate <-0.8, 0.3, 0> }
merge { sphere { <-0.3, 0, 0>, 0.4 } sphere { <0.2, 0, 0>, 0.4 } texture { Wax } interior { ior 1.4 } translate <0.8, 0.3, 0> }
difference { sphere { 0, 0.5 } sphere { <-0.2, 0.3, -0.4>, 0.4 } texture { Wax } interior { ior 1.4 } translate <0, -0.5, -0.6> }
