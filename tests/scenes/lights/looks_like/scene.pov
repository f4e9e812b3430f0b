// A lamp that is seen.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
light_source { <1.2, 1.2, -0.8> rgb 1 looks_like { sphere { 0, 0.25 pigment { rgb <1, 1, 0.6> } finish { emission 1 } } } fade_distance 2 fade_power 1 }
sphere { -0.5*x, 0.6 pigment { rgb <0.8, 0.25, 0.2> } finish { phong 0.6 phong_size 60 } }
