// Functions that ask a pigment of pigments and a pattern that is a function.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
plane { y, -1 pigment { rgb <0.6, 0.65, 0.7> } }
#declare Rings = function { abs(sin(6*x)) * 0.5 + 0.5*y*y }
#declare Mixed = function { pigment { gradient x pigment_map {
  [0.2 wood scale 0.3 color_map { [0 rgb 0] [1 rgb 1] }]
  [0.8 function { Rings(x, y, z) } color_map { [0 rgb <0.9, 0.2, 0>] [1 rgb <0, 0.5, 1>] }] } scale 0.7 } }
#declare Bent = function { pattern { function { Rings(y, x, z) } frequency 2 triangle_wave scale 0.8 } }
sphere { <-0.8, 0, 0>, 0.9 pigment { function { Mixed(x, y, z).gray } color_map { [0 rgb <0.1, 0.1, 0.4>] [0.5 rgb <0.9, 0.6, 0.3>] [1 rgb 1] } } }
box { <0.3, -1, -0.5>, <1.6, 0.6, 0.7> pigment { function { Bent(x, y, z) } } rotate 10*y }
