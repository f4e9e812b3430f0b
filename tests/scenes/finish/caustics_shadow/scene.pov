// The strength of the caustics trick, over a large shadow.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <0, 3, -4> look_at <0, -1, 0> angle 50 right 4/3*x }
plane { y, -1 pigment { rgb 0.4 } finish { ambient 0 } }
light_source { <0, 6, 0> rgb 1 }
sphere { <0, 0.6, 0>, 1 pigment { rgbf <0.5, 0.6, 0.7, 0.9> } interior { ior 1.4 caustics 0.7 } }
