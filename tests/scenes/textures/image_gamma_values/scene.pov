// A `gamma` of pictures that give values decodes them, whatever the scene's own gamma.
#version 3.7;
global_settings { assumed_gamma 2.2 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
height_field { pgm "hills.pgm" gamma 1.8 smooth translate -0.5 scale <1.5, 0.8, 1.5> translate <-0.8, -0.3, 0> pigment { rgb <0.8, 0.7, 0.5> } }
box { -0.55, 0.55 translate <0.9, 0.2, 0> pigment { image_pattern { pgm "hills.pgm" gamma srgb interpolate 2 } color_map { [0 rgb <0.1, 0.2, 0.5>] [0.5 rgb <0.8, 0.3, 0.2>] [1 rgb <1, 0.9, 0.5>] } } }
sphere { <0.2, 1.1, 0.6>, 0.5 pigment { rgb 0.8 } normal { bump_map { pgm "hills.pgm" gamma 2.2 map_type 1 bump_size 6 } } }
