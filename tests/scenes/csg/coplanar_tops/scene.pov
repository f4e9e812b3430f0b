// Boxes whose tops lie in the top of a larger one: both machines see them in one order. POV-Ray sees 0.8 % of the pixels otherwise.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <3, 3.7, -6.3> look_at <0, -0.3, 0.2> angle 40 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
#declare Square = box { <-0.5, -0.3, -0.5>, <0.5, 0, 0.5> pigment { rgb <0.35, 0.15, 0.1> } }
union {
  box { <-1, -1, -1>, <1, 1, 1> scale <2.25, 0.25, 2> translate -0.25*y pigment { rgb <0.8, 0.7, 0.4> } }
  object { Square translate <-1.2, 0, -1.1> }
  object { Square scale <1.25, 0.5, 0.75> translate <-0.6, 0, 0.9> }
}
box { <-0.6, -0.4, -0.6>, <0.6, 0, 0.6> translate <1.3, 0, 1.6> pigment { rgb <0.2, 0.3, 0.7> } }
box { <-0.4, -0.4, -0.4>, <0.4, 0, 0.4> translate <1.9, 0, 1.9> pigment { rgb <0.2, 0.7, 0.3> } }
