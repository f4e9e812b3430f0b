// Fractals enlarged tens of thousands of times: what 32 bits hold of the place is a few steps.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location -4*z look_at 0 angle 50 right 4/3*x }
#declare Colors = color_map { [0 rgb 0] [0.25 rgb <0.5, 0, 0.5>] [0.5 rgb x] [0.75 rgb x + y] [1 rgb 1] }
plane { -z, 0 pigment { mandel 400 color_map { Colors } translate <0.743643887037151, -0.131825904205330> scale 20000 } finish { ambient 1 diffuse 0 } clipped_by { plane { x, 0 } } }
plane { -z, 0 pigment { julia <-0.8, 0.156>, 400 color_map { Colors } frequency 8 translate <-1.5275031186435346, 0.07591217835228786> scale 300000 } finish { ambient 1 diffuse 0 } clipped_by { plane { -x, 0 } } }
