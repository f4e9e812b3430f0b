// A version from the future.
#version 9.5;
sphere { 0, 1 }
