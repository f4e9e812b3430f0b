// Thin walls: light enters behind and what stands behind is seen through them, in two slabs one after the other, but not in a third.
#version 3.7;
global_settings { assumed_gamma 1.0 mm_per_unit 10 subsurface { samples 20, 5 } }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
#declare Slab = box { <-0.5, -0.9, -0.015>, <0.5, 0.6, 0.015> pigment { rgb <0.9, 0.8, 0.7> } finish { ambient 0 subsurface { translucency <3, 1.5, 0.8> } } interior { ior 1.3 } }
object { Slab translate <-0.7, 0, 0> }
object { Slab rotate y*20 translate <0.7, 0, 0> }
object { Slab translate <0.4, 0.2, 0.6> }
object { Slab translate <-0.3, 0.3, 1.2> }
sphere { <0, 0, 1.8>, 0.7 pigment { rgb <1, 0.2, 0.1> } finish { ambient 0.6 } }
