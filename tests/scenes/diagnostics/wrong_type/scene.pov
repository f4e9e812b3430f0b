// A vector where a number is wanted.
#version 3.7;
#declare A = sphere { 0, 1 }
sphere { 0, A }
