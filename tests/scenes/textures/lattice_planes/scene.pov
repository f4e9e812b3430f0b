// Surfaces that lie on the sides of cells, and a little beside them.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
box { <-1.8, -0.99999, -0.6>, <-0.6, 0.2, 0.6> pigment { checker rgb <0.8, 0.2, 0.2>, rgb <0.9, 0.9, 0.8> scale 0.2 } }
box { <-0.4, -0.99999, -0.600002>, <0.6, 0.2, 0.4> pigment { brick rgb 0.8, rgb <0.6, 0.2, 0.15> brick_size <0.5, 0.2, 0.4> mortar 0.05 } }
box { <0.8, -0.99999, -0.6>, <1.6, 0.2, 0.2> pigment { cells scale 0.2 } }
