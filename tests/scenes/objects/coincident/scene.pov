// Surfaces of two objects that lie on each other: what POV-Ray asks first is seen. Tiles that are level with a plane, declared before and after it;
// a glass block and a glass die that stand on a table, whose bottoms are met before the table's top.
#version 3.7;
global_settings { assumed_gamma 1 max_trace_level 8 }
camera { location <0.4, 3.1, -4.6> look_at <0, -0.1, 0> angle 42 }
light_source { <5, 9, -4> rgb 1 }
background { rgb <0.5, 0.6, 0.7> }
#default { finish { ambient 0.3 diffuse 0.7 } }

box { -0.6, 0.6 pigment { rgb <0.9, 0.2, 0.1> } rotate 20*y translate <-1.5, -1.6, 0.9> }
plane { y, -1 pigment { checker rgb 0.9 rgb 0.6 scale 0.4 } }
box { <1, -2, 0.4>, <2.1, -1, 1.5> pigment { rgb <0.1, 0.3, 0.9> } }

box { <-1.6, -0.3, -1.2>, <1.6, 0, 0.3> pigment { checker rgb <0.8, 0.6, 0.3> rgb <0.5, 0.3, 0.2> scale 0.25 translate 0.1*y } }
box { -0.4, 0.4 pigment { rgbf <0.6, 0.8, 0.8, 0.9> } interior { ior 1.45 } rotate 32*y translate <-0.7, 0.4, -0.5> }
difference {
  box { -1, 1 }
  sphere { <1, 1, -1>, 0.5 }
  pigment { rgbf <0.9, 0.7, 0.7, 0.9> } interior { ior 1.3 } scale 0.35 rotate -25*y translate <0.6, 0.35, -0.5>
}
