// An area light that shades from every one of its points.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <2, 2.5, -2> rgb 1 area_light 3*x, 3*z, 4, 4 area_illumination on fade_distance 3 fade_power 2 }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
sphere { 0, 0.7 pigment { rgb <0.8, 0.25, 0.2> } finish { phong 0.6 phong_size 60 } }
