// Interior fade by power and by exponent, and total reflection.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
sphere { <-0.9, 0, 0>, 0.8 pigment { rgbf 1 } finish { specular 0.6 } interior { ior 1.4 fade_distance 0.6 fade_power 2 fade_color <0.9, 0.4, 0.3> } }
box { <0.2, -0.9, -0.6>, <1.4, 0.6, 0.4> pigment { rgbf 1 } finish { reflection { 0, 1 fresnel } } interior { ior 1.6 fade_distance 0.8 fade_power 1001 fade_color <0.3, 0.9, 0.6> } rotate 25*y }
