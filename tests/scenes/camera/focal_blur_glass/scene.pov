// Focal blur of glass and mirrors, with antialiasing, until the variance is low.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x aperture 0.25 blur_samples 4, 37 focal_point <0.2, 0.2, -0.6> variance 1/2000 confidence 0.9 }
light_source { <4, 6, -5> rgb 0.9 }
plane { y, -1 pigment { rgb <0.85, 0.82, 0.75> } finish { ambient 0.1 diffuse 0.7 } }
plane { z, 3 pigment { rgb <0.2, 0.3, 0.4> } finish { reflection 0.5 } }
sphere { <-0.6, 0, 0>, 0.7 pigment { rgbf <0.9, 0.6, 0.5, 0.8> } finish { phong 0.6 } interior { ior 1.4 } }
box { <0.6, -1, -0.3>, <1.2, 0.4, 0.4> pigment { rgb <0.2, 0.35, 0.8> } }
