// Fewer rays look at what is less important, and count more.
#version 3.7;
global_settings { assumed_gamma 1.0 radiosity { count 30 recursion_limit 1 pretrace_start 0.08 pretrace_end 0.04 nearest_count 1 error_bound 0.5 } }
#default { radiosity { importance 0.7 } }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <2, 8, -2> rgb 0.9 }
sky_sphere { pigment { rgb 0.4 } }
plane { y, -1 pigment { rgb 0.7 } finish { diffuse 0.7 } radiosity { importance 1 } }
box { <-1.5, -1, 0.8>, <1, 0.8, 1> pigment { rgb <1, 0.5, 0.3> } finish { diffuse 0.7 } radiosity { importance 0.3 } }
sphere { <0.8, -0.4, 0>, 0.6 pigment { rgb <0.3, 0.5, 1> } finish { diffuse 0.7 } }
