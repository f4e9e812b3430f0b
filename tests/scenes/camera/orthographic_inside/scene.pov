// Parallel rays some of which start in one body of glass, some in another, some in the open.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { orthographic location <0, 1, -4> look_at <0, -0.2, 0> right 4*x up 3*y }
cylinder { <-0.9, -2, -4>, <-0.9, 4, -4>, 0.6 pigment { rgbf <0.9, 1, 0.7, 0.8> } interior { ior 1.3 fade_distance 1 fade_power 1 } }
box { <0.2, 0.4, -5>, <1.6, 1.9, -3.2> pigment { rgbf <0.7, 0.85, 1, 0.8> } interior { ior 1.1 } }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
sphere { <-0.6, -0.3, 0>, 0.7 pigment { rgb <0.8, 0.25, 0.2> } finish { phong 0.6 phong_size 60 } }
box { <0.6, -1, -0.3>, <1.2, 0.4, 0.4> pigment { rgb <0.2, 0.35, 0.8> } finish { specular 0.5 roughness 0.03 } }
