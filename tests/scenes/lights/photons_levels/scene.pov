// Panes count a level each; weak photons end.
#version 3.7;
global_settings { assumed_gamma 1.0 photons { spacing 0.05 radius 0.25 max_trace_level 4 adc_bailout 0.2 } }
camera { location <0, 4, -6> look_at <0, -0.2, 0> angle 42 right 4/3*x }
plane { y, -1 pigment { rgb <0.9, 0.85, 0.8> } finish { ambient 0.05 diffuse 0.7 } }
light_source { <3, 8, -2> rgb 0.9 photons { refraction on reflection on } }
box { <-1.6, 0.8, -1>, <1.6, 0.85, 1> pigment { rgbf <1, 0.9, 0.8, 0.95> } finish { ambient 0 diffuse 0.1 reflection 0.3 } photons { target } }
box { <-1.6, 0.3, -1>, <1.6, 0.35, 1> pigment { rgbf <1, 0.9, 0.8, 0.95> } finish { ambient 0 diffuse 0.1 reflection 0.3 }  }
box { <-1.6, -0.3, -1>, <1.6, -0.25, 1> pigment { rgbf <1, 0.9, 0.8, 0.95> } finish { ambient 0 diffuse 0.1 reflection 0.3 }  }
