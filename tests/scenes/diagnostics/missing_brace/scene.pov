// A brace that is never closed.
#version 3.7;
sphere { 0, 1 pigment { rgb 1 }
box { 0, 1 }
