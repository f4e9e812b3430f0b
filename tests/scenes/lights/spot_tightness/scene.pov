// The tightness of spotlights.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
light_source { <-2, 4, -3> rgb 1 spotlight point_at <-0.6, 0, 0> radius 5 falloff 25 tightness 30 }
light_source { <3, 4, -3> rgb <0.5, 0.6, 1> spotlight point_at <0.8, -1, 0> radius 10 falloff 14 tightness 0 }
sphere { <-0.6, -0.3, 0>, 0.7 pigment { rgb <0.8, 0.25, 0.2> } finish { phong 0.6 phong_size 60 } }
box { <0.6, -1, -0.3>, <1.2, 0.4, 0.4> pigment { rgb <0.2, 0.35, 0.8> } finish { specular 0.5 roughness 0.03 } }
