// A light group without the lamps outside.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
light_source { <4, 6, -5> rgb 0.7 }
light_group { light_source { <-3, 2, -3> rgb <0.3, 1, 0.3> } sphere { <-0.8, 0, 0>, 0.8 pigment { rgb <0.8, 0.25, 0.2> } finish { phong 0.6 phong_size 60 } } global_lights off }
sphere { <0.9, 0, 0>, 0.8 pigment { rgb <0.8, 0.25, 0.2> } finish { phong 0.6 phong_size 60 } }
