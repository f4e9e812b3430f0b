// Area lights that are parallel, cylinders, of one point in a direction, coloured below zero, and circular ones that shade from all points.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { rgb <0.85, 0.82, 0.75> } finish { ambient 0.1 diffuse 0.7 brilliance 1.4 } }
sphere { <-0.7, -0.2, 0>, 0.7 pigment { rgb <0.8, 0.25, 0.2> } finish { phong 0.6 phong_size 60 } }
box { <0.6, -1, -0.3>, <1.2, 0.4, 0.4> pigment { rgb <0.2, 0.35, 0.8> } finish { specular 0.5 roughness 0.03 } }
light_source { <3, 5, -3> rgb 0.4 parallel point_at 0 area_light 1.5*x, 1.5*z, 6, 1 }
light_source { <-2, 4, -2> rgb 0.4 cylinder point_at 0 radius 0.8 falloff 1.2 area_light x, z, 3, 2 adaptive 3 }
light_source { <0, 4, -4> rgb -0.1 area_light x, y, 2, 2 }
light_source { <2, 2.5, 1> rgb 0.5 area_light 3*x, 3*z, 4, 4 circular area_illumination on fade_distance 3 fade_power 1 }
