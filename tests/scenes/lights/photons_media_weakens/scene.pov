// Media on the way take from photons; those that collect none, and absorbing ones, keep no traces.
#version 3.7;
global_settings { assumed_gamma 1.0 photons { spacing 0.02 radius 0.15 media 20 } }
camera { location <0, 4, -6> look_at <0, -0.2, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { rgb <0.9, 0.85, 0.8> } finish { ambient 0.05 diffuse 0.7 } }
light_source { <3, 8, -2> rgb 0.9 photons { refraction on } }
box { <-2, 1, -2>, <2, 1.1, 2> pigment { rgbt 1 } finish { ambient 0 diffuse 0 } photons { target } }
box { <-1.8, -0.9, -1>, <-0.2, 0.6, 1> hollow pigment { rgbt 1 } finish { ambient 0 diffuse 0 } interior { media { absorption 0.4 } } }
box { <0.2, -0.9, -1>, <1.8, 0.6, 1> hollow pigment { rgbt 1 } finish { ambient 0 diffuse 0 } interior { media { scattering { 1, 0.3 } collect off } } }
