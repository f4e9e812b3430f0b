// A picture that is nowhere.
#version 3.7;
sphere { 0, 1 pigment { image_map { png "no_such.png" } } }
