// A glass ball that reflects and refracts a counted number of photons.
#version 3.7;
global_settings { assumed_gamma 1.0 photons { count 2000 } }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
sphere { 0, 0.8 pigment { rgbt 0.9 } interior { ior 1.5 } photons { target reflection on refraction on } }
