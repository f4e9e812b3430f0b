// A scale of the camera leaves the distance of the plane in focus alone.
#version 3.7;
global_settings { assumed_gamma 1.0 }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
light_source { <3, 5, -3> rgb 1 }
sphere { 0, 0.7 pigment { rgb <0.8, 0.25, 0.2> } finish { phong 0.6 phong_size 60 } }
camera { location <0, 0.2, -2> direction 1.4*z aperture 0.3 blur_samples 19 focal_point <0, 0.2, -0.2> scale 1.5 rotate 20*x }
