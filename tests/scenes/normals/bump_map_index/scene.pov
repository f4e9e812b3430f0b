// Interpolated palette indices as heights: they stay whole.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { orthographic location <0.5, 0.5, -1> look_at <0.5, 0.5, 0> right x up y }
light_source { <3, 5, -4> rgb 1 }
plane { z, 0 pigment { rgb 0.8 } normal { bump_map { gif "interlaced.gif" use_index interpolate 2 bump_size 0.4 } } }
