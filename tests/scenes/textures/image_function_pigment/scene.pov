// An image made of a pigment has its colours and transmit, no filter.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { orthographic location <0.5, 0.5, -1> look_at <0.5, 0.5, 0> right x up y }
plane { z, 0 pigment { image_map { function 12, 9 { pigment { bozo scale 0.3 color_map { [0.3 rgb <1, 0.2, 0.1>] [0.7 rgbft <0.1, 0.9, 0.3, 0.2, 0.3>] } } } } } finish { ambient 1 diffuse 0 } }
plane { z, 3 pigment { rgb <0.2, 0.4, 1> } finish { ambient 1 } }
