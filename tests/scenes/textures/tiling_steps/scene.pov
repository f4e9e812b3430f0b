// Colour maps that jump where the parts of a tiling begin.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { orthographic location <0, 0, -5> direction z right 8*x up 6*y }
#declare M = color_map { [0 rgb 0.1] [0.2 rgb x] [0.333333333 rgb y] [0.333333333 rgb <1, 1, 0>] [0.5 rgb z] [0.5 rgb 0.7] [0.666666667 rgb <1, 0, 1>] [0.666666667 rgb <0, 0.6, 0.4>] [0.8 rgb 0.2] [0.8 rgb <0.1, 0.5, 1>] [1 rgb 1] }
#declare N = array[6] { 8, 15, 17, 21, 22, 24 }
#for (I, 0, 5)
  box { <-4 + 2.6667*mod(I, 3), 3 - 3*int(I/3), 0>, <-1.3333 + 2.6667*mod(I, 3), -3*int(I/3), 1> pigment { tiling N[I] rotate 90*x scale 0.5 color_map { M } } finish { ambient 1 diffuse 0 } }
#end
