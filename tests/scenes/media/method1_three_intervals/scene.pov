// Random samples: rounding adds an interval that draws a number too.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
sphere { 0, 1 hollow pigment { rgbt 1 } interior { media { method 1 emission 0.6 intervals 3 samples 3, 3 density { spherical color_map { [0 rgb 0] [1 rgb <1, 0.5, 0.2>] } } } } }
