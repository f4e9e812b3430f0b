// Triangles of a mesh without uv_vectors look at (0, 0).
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
mesh {
  triangle { <-1.2, -0.8, 0>, <-0.1, -0.8, 0>, <-0.6, 0.8, 0> }
  triangle { <0.1, -0.8, 0>, <1.2, -0.8, 0>, <0.6, 0.8, 0> uv_vectors <0.3, 0.2>, <0.9, 0.2>, <0.5, 1> }
  uv_mapping
  texture { pigment { gradient x color_map { [0 rgb <0.9, 0.3, 0.2>] [1 rgb <0.2, 0.4, 0.9>] } } finish { ambient 0.3 } }
}
