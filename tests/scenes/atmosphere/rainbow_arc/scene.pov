// A part of a rainbow that falls off.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <0, 0.5, -4> look_at <0, 0.8, 0> angle 75 right 4/3*x }
background { rgb <0.3, 0.4, 0.5> }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
rainbow { angle 30 width 8 distance 6 direction <0, -0.1, 1> arc_angle 120 falloff_angle 60 color_map { [0 rgbt <1, 0.2, 0.2, 0.6>] [0.5 rgbt <0.2, 1, 0.3, 0.6>] [1 rgbt <0.3, 0.3, 1, 0.6>] } }
sphere { <-0.6, -0.3, 0>, 0.7 pigment { rgb <0.8, 0.25, 0.2> } finish { phong 0.6 phong_size 60 } }
box { <0.6, -1, -0.3>, <1.2, 0.4, 0.4> pigment { rgb <0.2, 0.35, 0.8> } finish { specular 0.5 roughness 0.03 } }
