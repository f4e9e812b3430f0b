// Transforms after the objects of clipped_by, bounded_by and the object pattern move them all.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
sphere { <-0.6, 0, 0>, 0.7 clipped_by { plane { -y, 0.2 } plane { x, 0.3 } rotate z*-30 translate <-0.6, 0, 0> } pigment { rgb <1, 0.5, 0.2> } interior_texture { pigment { rgb <0.2, 0.5, 1> } } }
union { sphere { <0.8, 0, 0>, 0.5 } box { <0.5, -1, -0.2>, <1.1, 0, 0.4> } bounded_by { box { -0.5, 0.5 } scale <1.2, 2, 1.2> translate <0.8, -0.3, 0> } pigment { object { sphere { 0, 0.5 } scale <1, 0.3, 1> translate <0.8, 0.1, 0> rgb <0.8, 0.8, 0.3>, rgb <0.6, 0.2, 0.4> } } }
