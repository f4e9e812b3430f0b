// A light is of one kind, and shadowless is one: the last word holds.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <0, 2.0, -4.5> look_at <0, 0, 0> angle 42 right 4/3*x }
light_source { <-3, 5, -4> rgb 0.2 cylinder radius 0.4 falloff 0.6 point_at <0, -1, 0> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
light_source { <-3, 5, -3> rgb <0.8, 0.3, 0.3> spotlight radius 5 falloff 12 point_at <-0.8, 0, 0> shadowless }
light_source { <3, 5, -3> rgb <0.3, 0.4, 0.9> shadowless spotlight radius 5 falloff 12 point_at <0.8, 0, 0> }
sphere { <-0.8, 0, 0>, 0.5 pigment { rgb 0.8 } finish { phong 0.8 } }
sphere { <0.8, 0, 0>, 0.5 pigment { rgb 0.8 } finish { phong 0.8 } }
