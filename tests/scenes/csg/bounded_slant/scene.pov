// A ray that meets the bounds of a set meets all of the set: seen from above, parts outside the bounds are there.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1, 3.5, -4> look_at 0 angle 45 }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
#declare Die = difference {
  box { -0.7, 0.7 }
  sphere { 0.7*<1, 1, -1>, 0.5 }
  bounded_by { box { <-1, 0, -1>, 1 } }
}
object { Die translate -x pigment { rgb <0.8, 0.35, 0.2> } }
object { Die scale 0.8 rotate 30*y translate x pigment { rgb <0.25, 0.4, 0.8> } }
intersection { plane { y, 0.4 } plane { x, 0.3 } sphere { 0, 1 } bounded_by { box { -0.4, 0.3 } } translate <0, 0, 1.5> pigment { rgb <0.8, 0.8, 0.3> } }
union { sphere { 0, 0.4 } box { 0, 0.5 } bounded_by { sphere { 0, 0.3 } } translate <0, 0, -1.2> pigment { rgb <0.3, 0.7, 0.7> } }
