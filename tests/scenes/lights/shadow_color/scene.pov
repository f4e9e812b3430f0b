// Coloured shadows through coloured glass.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
light_source { <4, 6, -5> rgb 0.9 }
box { <-1.3, -0.5, -0.8>, <-0.2, -0.4, 0.8> pigment { rgbf <1, 0.3, 0.2, 0.9> } }
box { <0.2, -0.5, -0.8>, <1.3, -0.4, 0.8> pigment { rgbt <0.2, 0.4, 1, 0.7> } }
