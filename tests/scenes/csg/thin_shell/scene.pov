// Shells a hundred-millionth thick, as bubbles in glass are written: the inner side is met, the outer one is left.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
difference {
  sphere { <-0.7, 0, 0>, 0.9 pigment { rgb <0.8, 0.3, 0.2> } }
  sphere { <-0.7, 0, 0>, 0.89999999 pigment { rgb <0.2, 0.7, 0.3> } }
  plane { z, -0.3 pigment { rgb <0.2, 0.4, 0.9> } }
}
merge {
  cylinder { <1, -0.9, 0>, <1, 0.3, 0>, 0.6 }
  sphere { <1, 0.3, 0>, 0.60000001 }
  pigment { rgbf <1, 0.6, 0.3, 0.9> }
  finish { reflection 0.2 }
  interior { ior 1.2 }
}
