// The film comes before the exponent of the reflection.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
sky_sphere { pigment { gradient y color_map { [0 rgb <0.9, 0.8, 0.7>] [1 rgb <0.2, 0.3, 0.8>] } } }
sphere { <-0.75, 0, 0>, 0.8 pigment { rgb 0.4 } finish { irid { 0.5 thickness 0.3 } reflection { 0.6 exponent 0.6 } } }
sphere { <0.85, 0, 0>, 0.7 pigment { rgb <0.5, 0.3, 0.2> } finish { irid { 0.4 thickness 0.6 } reflection { 0.2, 0.9 exponent 1.5 } } }
