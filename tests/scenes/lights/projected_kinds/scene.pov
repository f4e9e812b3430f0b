// Light through bodies cut from others, from an area light, from one without shadows, and past clear things.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { rgb <0.85, 0.82, 0.75> } finish { ambient 0.1 diffuse 0.7 } }
light_source { <0, 4, -1> rgb 0.8 projected_through { difference { box { <-0.8, 1.4, -1>, <0.8, 1.5, 0.6> } sphere { <0, 1.45, -0.2>, 0.35 } } } }
light_source { <3, 4, -3> rgb 0.5 area_light x, z, 4, 4 adaptive 1 projected_through { torus { 0.6, 0.15 rotate x*60 translate <1.5, 2, -1.5> } } }
light_source { <-4, 3, -2> rgb <0.2, 0.3, 0.5> shadowless projected_through { disc { <-2, 1.5, -1>, y, 0.4 } } }
sphere { <0.2, -0.4, 0>, 0.5 pigment { rgbt <0.8, 0.25, 0.2, 0.5> } finish { phong 0.6 phong_size 60 } }
