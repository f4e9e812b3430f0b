// The background in a mirror and through glass.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
background { rgb <0.3, 0.5, 0.7> }
sphere { <-0.8, 0, 0>, 0.8 pigment { rgb 0.1 } finish { reflection 0.8 } }
sphere { <0.9, 0, 0>, 0.8 pigment { rgbt 0.9 } interior { ior 1.4 } }
