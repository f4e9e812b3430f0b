// A group lights its own glass: lights of groups shoot no photons; with global_lights the glass is a target of the others.
#version 3.7;
global_settings { assumed_gamma 1.0 photons { spacing 0.03 radius 0.2 } }
camera { location <0, 4, -6> look_at <0, -0.2, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { rgb <0.9, 0.85, 0.8> } finish { ambient 0.05 diffuse 0.7 } }
light_source { <3, 8, -2> rgb 0.9 }
light_group { light_source { <-4, 5, 0> rgb 0.5 } sphere { <-1.3, 0, 0>, 0.8 pigment { rgbf 1 } interior { ior 1.5 } photons { target refraction on } } global_lights on }
light_group { light_source { <4, 5, 0> rgb 0.5 } sphere { <1.3, 0, 0>, 0.8 pigment { rgbf 1 } interior { ior 1.5 } photons { target refraction on } } }
