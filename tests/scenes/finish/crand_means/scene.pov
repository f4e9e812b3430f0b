// crand as means over many samples, which two generators of random numbers share.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> }
plane { y, -1 pigment { rgb <0.85, 0.82, 0.75> } finish { ambient 0.1 diffuse 0.7 crand 0.1 } }
sphere { <-0.8, 0, 0>, 0.8 pigment { rgb <0.8, 0.25, 0.2> } finish { crand 0.3 ambient 0.2 } }
sphere { <0.9, 0, 0>, 0.8 pigment { rgb <0.8, 0.25, 0.2> } finish { crand 0.05 reflection 0.3 } }
