// A prism cut to a blob, a superellipsoid with a tunnel of a quadric: hits of solvers under clip programs.
#version 3.7;
global_settings { assumed_gamma 1 }
camera { location <0, 3, -6> look_at <0, 0.1, 0> angle 40 }
light_source { <-6, 9, -7>, 1 }
background { rgb <0.1, 0.15, 0.25> }
#declare Red = texture { pigment { rgb <0.8, 0.3, 0.2> } finish { phong 0.4 } }
#declare Blue = texture { pigment { rgb <0.2, 0.4, 0.8> } }
intersection {
  prism { linear_spline -1, 1, 6, <-1, -1>, <1, -1>, <1.2, 0.4>, <0, 1>, <-1, 0.6>, <-1, -1> texture { Red } }
  blob { threshold 0.4 sphere { <-0.5, 0.2, 0>, 1.6, 1 } sphere { <0.7, -0.4, 0.2>, 1.3, 1 } texture { Blue } }
  rotate -20*y translate -1.4*x
}
difference {
  superellipsoid { <0.3, 0.6> texture { Red } }
  quadric { <1, 0, 1>, <0, 0, 0>, <0, 0, 0>, -0.35 texture { Blue } }
  rotate 25*y translate 1.4*x
}
