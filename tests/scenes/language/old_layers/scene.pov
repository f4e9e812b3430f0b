// Before language 3.5 upper layers let through unfiltered what they would filter.
#version 3.1;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
light_source { <3, 5, -3> rgb 1 }
sphere { 0, 0.9 texture { pigment { color rgb 0.9 } } texture { pigment { wood color_map { [0 color rgbf <1, 0.5, 0, 0.6>] [1 color rgbft <0.2, 0.4, 1, 0.5, 0.2>] } scale 0.3 } } }
