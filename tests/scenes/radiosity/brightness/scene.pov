// brightness and gray_threshold.
#version 3.7;
global_settings { assumed_gamma 1.0 radiosity { count 40 error_bound 0.8 recursion_limit 1 brightness 2 gray_threshold 0.5 } }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.5 }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
sphere { <-0.6, -0.3, 0>, 0.7 pigment { rgb <0.8, 0.25, 0.2> } finish { phong 0.6 phong_size 60 } }
box { <0.6, -1, -0.3>, <1.2, 0.4, 0.4> pigment { rgb <0.2, 0.35, 0.8> } finish { specular 0.5 roughness 0.03 } }
background { rgb <0.4, 0.5, 0.7> }
