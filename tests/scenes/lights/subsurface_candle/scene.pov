// Wax as in POV-Ray's candle: a blob, a translucency for each channel, highlights.
#version 3.7;
global_settings { assumed_gamma 1.0 mm_per_unit 4 subsurface { samples 20, 5 } }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
blob {
  threshold 0.5
  cylinder { <0, -1, 0>, <0, 0.4, 0>, 1.1, 1 }
  sphere { <0, 0.9, 0>, 0.8, -2 }
  sphere { <0.3, -0.2, -0.6>, 0.3, 0.5 }
  pigment { rgb <0.8, 0.5, 0.1> }
  finish { ambient 0 diffuse 0.6 specular 0.6 roughness 0.1 subsurface { translucency <5, 3, 1> * 0.5 } }
  interior { ior 1.45 }
}
