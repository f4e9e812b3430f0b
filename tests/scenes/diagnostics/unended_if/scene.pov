// An #if without its #end.
#version 3.7;
#if (1)
sphere { 0, 1 }
