// Wave shapes of a gradient, with frequency and phase.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
box { <-1.60, -1, -0.4>, <-1.15, 1, 0.2> pigment { gradient y ramp_wave frequency 1.7 phase 0.2 color_map { [0 rgb 0.05] [1 rgb <1, 0.8, 0.3>] } } }
box { <-1.05, -1, -0.4>, <-0.60, 1, 0.2> pigment { gradient y triangle_wave frequency 1.7 phase 0.2 color_map { [0 rgb 0.05] [1 rgb <1, 0.8, 0.3>] } } }
box { <-0.50, -1, -0.4>, <-0.05, 1, 0.2> pigment { gradient y sine_wave frequency 1.7 phase 0.2 color_map { [0 rgb 0.05] [1 rgb <1, 0.8, 0.3>] } } }
box { <0.05, -1, -0.4>, <0.50, 1, 0.2> pigment { gradient y scallop_wave frequency 1.7 phase 0.2 color_map { [0 rgb 0.05] [1 rgb <1, 0.8, 0.3>] } } }
box { <0.60, -1, -0.4>, <1.05, 1, 0.2> pigment { gradient y cubic_wave frequency 1.7 phase 0.2 color_map { [0 rgb 0.05] [1 rgb <1, 0.8, 0.3>] } } }
box { <1.15, -1, -0.4>, <1.60, 1, 0.2> pigment { gradient y poly_wave 3 frequency 1.7 phase 0.2 color_map { [0 rgb 0.05] [1 rgb <1, 0.8, 0.3>] } } }
