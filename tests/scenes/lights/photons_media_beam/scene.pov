// Where a photon leaves its light's beam its way through smoke is cut, as that of rays.
#version 3.7;
global_settings { assumed_gamma 1.0 photons { spacing 0.05 radius 0.3, 1, 0.3, 1 media 40, 1.5 } }
camera { location <0, 9, -3> look_at <0, 0, 0> angle 40 right 4/3*x }
light_source { <-20, 0.5, 0> rgb 1.2 spotlight radius 3 falloff 3.5 point_at <0, 0.5, 0> photons { refraction on reflection on } }
box { <-3, -0.1, -3>, <3, 1, 3> hollow pigment { rgbf 1 } interior { media { scattering { 1, rgb 0.3 extinction 0 } method 3 intervals 1 samples 4 } } photons { target } }
box { <-10, -1, -10>, <10, 0, 10> pigment { checker rgb 0.8, rgb <0.2, 0, 0.4> } finish { ambient 0 } }
box { <-0.05, 0, -0.8>, <0.05, 0.9, 0.8> pigment { rgb 1 } finish { ambient 0 diffuse 0 reflection 0.9 } rotate y*-40 photons { target reflection on } }
