// A name that nobody declared.
#version 3.7;
sphere { 0, Radius pigment { rgb 1 } }
