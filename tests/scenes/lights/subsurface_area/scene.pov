// Jittered area lights draw random numbers for light from below too.
#version 3.7;
global_settings { assumed_gamma 1.0 mm_per_unit 10 subsurface { samples 10, 3 } }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 area_light x*3, y*3, 4, 4 jitter adaptive 1 }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
sphere { 0, 0.8 pigment { rgb <0.9, 0.7, 0.6> } finish { ambient 0.05 subsurface { translucency 0.5 } } interior { ior 1.4 } }
