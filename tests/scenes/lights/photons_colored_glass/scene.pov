// Coloured glass that fades, fresnel reflection, light kept by conserve_energy.
#version 3.7;
global_settings { assumed_gamma 1.0 photons { spacing 0.03 radius 0.2 } }
camera { location <0, 4, -6> look_at <0, -0.2, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { rgb <0.9, 0.85, 0.8> } finish { ambient 0.05 diffuse 0.7 } }
light_source { <3, 8, -2> rgb 0.9 }
sphere { 0, 1 pigment { rgbft <1, 0.4, 0.2, 0.7, 0.2> } finish { ambient 0 diffuse 0 conserve_energy reflection { 0, 1 fresnel } } interior { ior 1.5 fade_distance 1 fade_power 2 fade_color <0.2, 0.9, 0.4> } photons { target refraction on reflection on } }
