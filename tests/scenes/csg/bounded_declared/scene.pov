// Bounds of a declared set hold for its copies: they are too small, so the lower half of each is gone.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { orthographic location <0, 0, -5> direction z right 4*x up 3*y }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
#declare Die = difference {
  box { -0.7, 0.7 }
  sphere { 0.7*<1, 1, -1>, 0.5 }
  bounded_by { box { <-1, 0, -1>, 1 } }
}
object { Die translate -x pigment { rgb <0.8, 0.35, 0.2> } }
object { Die scale 0.8 translate x pigment { rgb <0.25, 0.4, 0.8> } }
sphere { <0, 1.15, 0>, 0.3 pigment { rgb <0.3, 0.7, 0.3> } }
