// Balls and blocks of glass behind each other: each bend magnifies what the last one rounded away.
#version 3.7;
global_settings { assumed_gamma 1.0 max_trace_level 20 adc_bailout 0.01 }
camera { location <0.7, 1.4, -7> look_at <0, 0.9, 0> angle 36 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
sky_sphere { pigment { gradient y color_map { [0 rgb <0.3, 0.25, 0.2>] [1 rgb <0.5, 0.7, 1>] } } }
plane { y, -0.01 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
#declare Clear = material { texture { pigment { rgbf <0.92, 0.98, 1, 0.95> } finish { diffuse 0.1 reflection { 0.02, 0.6 fresnel } conserve_energy } } interior { ior 1.5 } }
#for (Z, 0, 2)
  #for (X, -1, 1)
    union {
      box { -0.4, 0.4 }
      rotate <0, 20*X + 15*Z, 0> translate <X*1.05, 0.4, Z*1.1>
      material { Clear }
    }
    sphere { <X*1.05 + 0.1*Z, 1.21, Z*1.1>, 0.4 material { Clear } }
  #end
#end
