// A string without its end.
#version 3.7;
#debug "never ended
sphere { 0, 1 }
