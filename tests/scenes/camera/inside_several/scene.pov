// The camera stands in five bodies at once: their interiors are entered in the order of the bounding hierarchy, not of the file.
#version 3.7;
global_settings { assumed_gamma 1 max_trace_level 12 }
camera { location 0 look_at <0.2, 0.1, 1> angle 80 }
light_source { <5, 9, -7>, 1 }
plane { y, -2 pigment { checker rgb <1, 0.5, 0.2> rgb 0.2 } finish { ambient 0.3 } }
#for (I, 0, 11)
  sphere { <I - 6, -1.5, 5 + mod(I, 3)>, 0.4 pigment { rgb <I / 12, 0.3, 1 - I / 12> } finish { ambient 0.3 } }
#end
#macro Clear(C, N, F)
  pigment { rgb C transmit 0.9 } finish { ambient 0 specular 0.3 }
  interior { ior N fade_distance 1 fade_power 1 fade_color F }
#end
sphere { x * 0.5, 1 Clear(<1, 0.8, 0.8>, 1.5, <1, 0.2, 0.2>) }
plane { y, 0.6 Clear(<0.8, 0.8, 1>, 1.2, <0.2, 0.2, 1>) }
intersection {
  sphere { -x * 0.3, 1.2 }
  box { <-2, -0.8, -0.8>, <2, 2, 1.8> }
  Clear(<0.8, 1, 0.8>, 1.35, <0.2, 1, 0.2>)
}
merge {
  sphere { y * 0.2, 0.9 }
  cylinder { -x, x * 1.4, 0.6 }
  Clear(<1, 1, 0.8>, 1.7, <1, 1, 0.2>)
}
cone { <0, -1.6, 0.2>, 1.5, <0.1, 1.5, 0>, 0.7 Clear(<1, 0.8, 1>, 1.1, <1, 0.2, 1>) }
// A union that is entered twice, and the outside of a ball whose box is elsewhere: nobody starts in that.
union {
  sphere { <0.4, 0.1, -0.3>, 0.95 }
  sphere { <-0.2, 0.15, 0.1>, 1.05 pigment { rgb <0.8, 1, 1> transmit 0.9 } interior { ior 1.25 } }
  sphere { <0, -0.3, 0.2>, 0.85 }
  Clear(<0.9, 0.9, 1>, 1.55, <0.4, 0.6, 1>)
}
sphere { <-1.2, 2.3, 6>, 0.9 inverse Clear(<1, 0.9, 0.8>, 1.15, <1, 0.6, 0.2>) }
