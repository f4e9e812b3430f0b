// Kerning with pairs that the font does not keep in order.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <2, 0.6, -4.4> look_at <2, 0.6, 0> right 4/3*x }
light_source { <3, 5, -3> rgb 1 }
text { ttf "timrom.ttf" "Te To Yo P. Ty" 0.1, 0 scale 0.6 translate <0, 1, 0> pigment { rgb <1, 0.6, 0.2> } finish { ambient 1 } }
text { ttf "timrom.ttf" "AVAVA We" 0.1, 0 scale 0.8 pigment { rgb <0.3, 0.7, 1> } finish { ambient 1 } }
