// Smooth and textured mesh2.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
#declare S = 0.8;
mesh2 {
  vertex_vectors { 6, <S,0,0>, <-S,0,0>, <0,S,0>, <0,-S,0>, <0,0,S>, <0,0,-S> }
  normal_vectors { 6, x, -x, y, -y, z, -z }
  face_indices { 8, <0,2,4>, <2,1,4>, <1,3,4>, <3,0,4>, <2,0,5>, <1,2,5>, <3,1,5>, <0,3,5> }
  pigment { rgb <0.8, 0.4, 0.6> } finish { phong 0.7 } rotate <10, 25, 0> translate -0.9*x
}
mesh2 {
  vertex_vectors { 4, <-0.7,-0.7,0>, <0.7,-0.7,0>, <0.7,0.7,0>, <-0.7,0.7,0> }
  uv_vectors { 4, <0,0>, <1,0>, <1,1>, <0,1> }
  texture_list { 2, texture { pigment { rgb <1, 0.5, 0.1> } }, texture { pigment { rgb <0.1, 0.6, 0.7> } } }
  face_indices { 2, <0,1,2>, 0, <0,2,3>, 1 }
  translate <1, 0, 0.2>
}
