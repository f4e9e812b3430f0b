// Area lights through filtering and fading bodies, in a mirror, and one that belongs to a group.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { rgb <0.85, 0.82, 0.75> } finish { ambient 0.1 diffuse 0.7 } }
plane { z, 2.5 pigment { rgb 0.3 } finish { reflection 0.5 diffuse 0.3 } }
light_source { <3, 5, -3> rgb 0.8 area_light 2*x, 2*z, 9, 9 adaptive 0 }
sphere { <-0.7, -0.2, 0>, 0.7 pigment { rgbf <0.9, 0.5, 0.3, 0.8> } finish { phong 0.6 } interior { ior 1.3 fade_distance 1 fade_power 1 } }
box { <0.6, -1, -0.3>, <1.2, 0.4, 0.4> pigment { rgbt <0.2, 0.35, 0.8, 0.5> } }
light_group {
    light_source { <-3, 3, -2> rgb <0.3, 0.5, 0.3> area_light x, z, 17, 3 adaptive 2 }
    sphere { <0.2, -0.7, -1>, 0.3 pigment { rgb 0.8 } }
}
