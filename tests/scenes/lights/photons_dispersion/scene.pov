// A prism splits white light.
#version 3.7;
global_settings { assumed_gamma 1.0 photons { spacing 0.04 radius 0.15 } }
camera { location <0, 4, -6> look_at <0, -0.2, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { rgb 0.9 } finish { ambient 0.05 diffuse 0.7 } }
light_source { <-8, 3, 0> rgb 1.2 spotlight radius 4 falloff 5 point_at <0, 0, 0> }
prism { -0.8, 0.8, 4, <-0.7, 0>, <0, 1.2>, <0.7, 0>, <-0.7, 0> rotate -x*90 translate -0.4*y pigment { rgbf 1 } finish { ambient 0 diffuse 0 } interior { ior 1.5 dispersion 1.15 dispersion_samples 12 } photons { target refraction on } }
