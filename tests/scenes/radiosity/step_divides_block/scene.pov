// Steps of the pretrace that divide a block of 32 pixels, and one that ends within half a pixel of it.
#version 3.7;
global_settings { assumed_gamma 1.0 radiosity { count 40 error_bound 0.5 recursion_limit 1 pretrace_start 0.08 pretrace_end 0.0396 } }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
sphere { <-0.6, -0.3, 0>, 0.6 pigment { rgb <1, 0.6, 0.3> } finish { emission 3 } }
box { <0.6, -1, -0.3>, <1.2, 0.4, 0.4> pigment { rgb 0.8 } }
plane { y, -1 pigment { rgb 0.8 } }
