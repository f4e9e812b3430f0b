// Isosurfaces of a loop: equal functions, and functions that differ in numbers alone. On the GPU each kind is one text.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <0, 6, -9> look_at <0, -0.4, 0> angle 44 right 4/3*x }
light_source { <4, 9, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -0.4 pigment { rgb <0.85, 0.82, 0.75> } finish { ambient 0.1 diffuse 0.7 } }
#include "functions.inc"
#declare K = 0;
#while (K < 24)
  #declare X = mod(K, 6) - 2.5;
  #declare Z = int(K / 6) - 1.5;
  isosurface {
    #switch (int(K / 6))
      #range (0, 1) function { f_r(x, y, z) - 0.7 + 0.4*f_noise3d(2*x, 2*y, 2*z) } #break
      #case (2) function { sqrt(x*x + y*y/(1 + K/20) + z*z) - 0.6 - 0.1*sin((3 + mod(K, 6))*x)*sin(5*z) } #break
      #else function { abs(x) + abs(y) + abs(z) - 0.5 - 0.02*mod(K, 6) + 0.1*sin(K + 9*y) }
    #end
    contained_by { sphere { 0, 0.95 } }
    max_gradient 4
    rotate K*25*y
    scale 0.55
    translate <1.2*X, 0, 1.3*Z>
    pigment { rgb <0.4 + 0.1*mod(K, 6), 0.65, 0.9 - 0.15*int(K / 6)> }
  }
  #declare K = K + 1;
#end
