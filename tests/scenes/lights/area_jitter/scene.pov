// Jittered area lights: one of few points, a single row that shades from each of its points, a grid that adapts. Means over many samples are compared.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { rgb <0.85, 0.82, 0.75> } finish { ambient 0.1 diffuse 0.7 } }
sphere { <-0.7, -0.2, 0>, 0.7 pigment { rgb <0.8, 0.25, 0.2> } finish { phong 0.6 phong_size 60 } }
box { <0.6, -1, -0.3>, <1.2, 0.4, 0.4> pigment { rgb <0.2, 0.35, 0.8> } finish { specular 0.5 roughness 0.03 reflection 0.2 } }
light_source { <3, 5, -3> rgb 0.4 area_light 3*x, 3*z, 2, 2 jitter }
light_source { <-3, 3, -2> rgb <0.3, 0.35, 0.4> area_light 3*x, 3*z, 1, 2 jitter area_illumination on }
light_source { <1, 5, 3> rgb 0.3 area_light 2*x, 2*z, 5, 5 adaptive 1 jitter circular orient }
