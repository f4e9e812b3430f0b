// Textures chosen by the index of a picture that the scene makes.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
box { <-1.3, -1, -0.2>, <1.3, 1, 0.2> texture { material_map { function 8, 8 { mod(floor(8*x) + floor(8*y), 3)/3 } texture { pigment { rgb <0.9, 0.2, 0.1> } finish { phong 0.7 } } texture { pigment { checker rgb 1, rgb 0 scale 0.1 } } texture { pigment { rgb <0.1, 0.3, 0.8> } finish { reflection 0.3 } } } translate <-0.5, -0.5, 0> scale <2.6, 2, 1> } rotate 20*y }
