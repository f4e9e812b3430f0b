// The film of the top layer tints total reflection in glass.
#version 3.7;
global_settings { assumed_gamma 1.0 max_trace_level 8 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
sky_sphere { pigment { gradient y color_map { [0 rgb 0.9] [1 rgb <0.3, 0.5, 0.9>] } } }
#declare Film = finish { ambient 0 diffuse 0 reflection 0.05 irid { 0.6 thickness 0.8 turbulence 0.1 } }
prism { linear_spline -0.9, 0.9, 4, <-0.6, -0.5>, <0.6, -0.5>, <0, 0.5>, <-0.6, -0.5> rotate z*90 rotate y*25 translate <-0.2, -0.4, 0> pigment { rgbf 1 } finish { Film } interior { ior 1.5 } }
