// Jittered rainbows: means over many samples are compared.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <0, 0, -5> look_at 0 }
background { rgb 0.3 }
#declare M = color_map { [0 rgbf <1, 0, 1, 1>] [0.5 rgbf <0, 1, 0, 0.8>] [1 rgbf <1, 0, 0, 0.8>] }
rainbow { angle 32.5 width 15 distance 1e7 direction <-0.2, -0.2, 1> jitter 0.05 color_map { M } }
rainbow { angle 22.5 width 12 distance 1e7 direction <-0.2, -0.2, 1> jitter 0.02 color_map { M } }
