// Media inside each other and inside glass, their shadows, and a light group's medium.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { rgb <0.85, 0.82, 0.75> } finish { ambient 0.1 diffuse 0.7 } }
light_source { <3, 5, -3> rgb 0.9 }
sphere { <-0.6, 0, 0>, 0.9 hollow pigment { rgbt 1 } interior { media { method 3 absorption <0.2, 0.6, 0.9> samples 6 density { bozo scale 0.4 color_map { [0.3 rgb 0] [0.6 rgb 1.5] } } } } }
box { <-1, -0.5, -0.4>, <0.1, 0.3, 0.4> hollow pigment { rgbt 1 } interior { ior 1.2 media { method 3 scattering { 4, rgb 0.9 extinction 1 } samples 8 aa_threshold 0.02 aa_level 4 } media { emission <0.1, 0, 0.2> method 3 } } }
light_group {
    light_source { <-3, 3, -2> rgb <0.4, 0.7, 0.4> }
    sphere { <0.9, -0.3, -0.3>, 0.6 hollow pigment { rgbf 0.95 } finish { phong 0.5 } interior { media { method 3 scattering { 5, rgb 0.8 eccentricity 0.3 } samples 7 } } }
    global_lights off
}
