// A beam bent by a lens shows in smoke.
#version 3.7;
global_settings { assumed_gamma 1.0 photons { spacing 0.06 radius 0.2, 1, 0.15, 1 media 60 } }
camera { location <0, 4, -6> look_at <0, -0.2, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { rgb 0.8 } finish { ambient 0.02 diffuse 0.6 } }
light_source { <-9, 0, 0> rgb 1.5 parallel point_at 0 photons { refraction on } }
sphere { 0, 1 scale <0.4, 0.9, 0.9> translate -1.2*x pigment { rgbf 1 } finish { ambient 0 diffuse 0 } interior { ior 1.5 } photons { target } }
box { <-0.7, -0.95, -0.9>, <2.4, 0.95, 0.9> hollow pigment { rgbt 1 } finish { ambient 0 diffuse 0 } interior { media { scattering { 1, <0.25, 0.3, 0.35> } samples 12 } } }
