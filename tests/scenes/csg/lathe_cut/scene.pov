// A lathe cut open, a height field cut to a cylinder: shapes of many hits under clip programs.
#version 3.7;
global_settings { assumed_gamma 1 }
camera { location <0, 3, -6> look_at <0, 0.1, 0> angle 40 }
light_source { <-6, 9, -7>, 1 }
background { rgb <0.1, 0.15, 0.25> }
#declare Red = texture { pigment { rgb <0.8, 0.3, 0.2> } finish { phong 0.4 } }
#declare Blue = texture { pigment { rgb <0.2, 0.4, 0.8> } }
difference {
  lathe { cubic_spline 6, <0.2, -1.4>, <0.4, -1>, <1, -0.3>, <0.5, 0.4>, <0.8, 1>, <0.6, 1.6> texture { Red } }
  box { <0, -2, -2>, <2, 2, 0> rotate 20*y texture { Blue } }
  translate -1.4*x
}
intersection {
  height_field { function 40, 40 { 0.4 + 0.3*sin(9*x)*cos(9*y) } smooth translate <-0.5, 0, -0.5> scale <2.4, 2, 2.4> texture { Red } }
  cylinder { -1.5*y, 1.5*y, 1.05 texture { Blue } }
  translate <1.3, -1, 0>
}
