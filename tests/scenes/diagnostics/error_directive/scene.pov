// #error stops with its text.
#version 3.7;
#if (1 < 2) #error "this scene wants more" #end
