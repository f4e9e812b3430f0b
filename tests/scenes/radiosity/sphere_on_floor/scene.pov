// Gathered light between a sphere and a floor.
#version 3.7;
global_settings { assumed_gamma 1.0 radiosity { recursion_limit 1 } }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { rgb <0.9, 0.6, 0.4> } }
sky_sphere { pigment { gradient y color_map { [0 rgb <0.4, 0.5, 0.8>] [1 rgb <1, 0.5, 0>] } } }
sphere { 0, 0.7 pigment { rgb <0.8, 0.25, 0.2> } finish { phong 0.6 phong_size 60 } }
