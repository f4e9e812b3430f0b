// Two sky pigments, seen and reflected.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <0, 0.6, -4.5> look_at <0, 0.9, 0> angle 60 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
sky_sphere { pigment { gradient y color_map { [0 rgb <0.9, 0.85, 0.7>] [0.3 rgb <0.3, 0.5, 0.9>] } } pigment { bozo turbulence 0.6 color_map { [0.5 rgbt 1] [0.9 rgbt <1, 1, 1, 0.2>] } scale <0.4, 0.15, 0.4> } }
sphere { <0, 0.3, 0>, 0.6 pigment { rgb 0.1 } finish { reflection 0.6 } }
