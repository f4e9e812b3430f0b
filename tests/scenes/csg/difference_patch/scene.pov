// Patches have no inside, turned round neither: nothing of the first bodies is left, but the patch within.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
difference { sphere { <-0.7, 0, 0>, 0.7 pigment { rgb x } } triangle { <-1.6, -0.9, -0.2>, <0.2, -0.9, 0>, <-0.7, 0.9, 0.3> pigment { rgb <0.9, 0.8, 0.2> } } }
intersection {
  box { <0.2, -0.6, -0.5>, <1.2, 0.4, 0.5> pigment { rgb z } }
  mesh { triangle { <0, -0.9, -0.2>, <1.4, -0.9, 0>, <0.7, 0.9, 0.3> } triangle { <0, 0.5, 0>, <1.4, 0.5, 0>, <0.7, 0, 0.3> } inverse pigment { rgb <0.3, 0.8, 0.5> } }
}
