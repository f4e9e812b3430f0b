// Waves of a hundred thousand turns a unit in a pattern as much larger: their fraction counts.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <0, 2.5, -6> look_at <0, 0, 1> angle 45 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
sky_sphere { pigment { gradient y color_map { [0 rgb <0.9, 0.7, 0.5>] [1 rgb <0.2, 0.3, 0.7>] } } }
plane { y, 0 pigment { rgb <0.2, 0.35, 0.5> } finish { reflection { 0.1, 0.8 } diffuse 0.4 }
  normal { average normal_map {
    [1 waves 0.3 translate -0.5 scale <1, 0.05, 1>*100000 frequency 100000]
    [1 ripples 0.2 translate -0.5 scale 100000 frequency 100000] } } }
box { <-1.5, 0.4, 0.5>, <1.5, 1.6, 0.6> pigment { ripples scale 10000 frequency 20000 color_map { [0 rgb 0.1] [1 rgb <1, 0.9, 0.6>] } } finish { ambient 0.3 } }
