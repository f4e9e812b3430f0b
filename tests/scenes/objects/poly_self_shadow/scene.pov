// A saddle that shades itself: rays that start on a polynomial's surface find what lies behind it, though the value at their start is rounding.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.5, 1.2, -7> look_at <0, -0.1, 0> angle 40 right 4/3*x }
light_source { <30, 12, -34> rgb 1 }
background { rgb <0.1, 0.12, 0.15> }
intersection {
  cubic { <1, 0, 0, 0, -3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1.2, 0.1> pigment { rgb <0.9, 0.4, 0.2> } finish { ambient 0.1 diffuse 0.8 specular 0.5 } }
  box { -1.6, 1.6 pigment { rgbt 1 } }
  rotate <-25, 30, 0>
}
