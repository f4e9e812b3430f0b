// POV-Ray leaves the rows of an interlaced GIF in the order of the file.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { orthographic location <0.5, 0.5, -1> look_at <0.5, 0.5, 0> right x up y }
plane { z, 0 pigment { image_map { gif "interlaced.gif" } } finish { ambient 1 diffuse 0 } }
