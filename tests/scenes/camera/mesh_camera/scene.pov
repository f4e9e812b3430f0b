// Rays that start on the faces of a mesh.
#version 3.7;
global_settings { assumed_gamma 1.0 }
#declare Screen = mesh2 {
  vertex_vectors { 4, <-2, -1.2, -3>, <2, -1.2, -3>, <2, 1.8, -3>, <-2, 1.8, -3> }
  uv_vectors { 4, <0, 0>, <1, 0>, <1, 1>, <0, 1> }
  face_indices { 2, <0, 2, 1>, <0, 3, 2> }
}
camera { mesh_camera { 1 3 mesh { Screen } } location <0, 0, 0.01> direction <0, 0, 1> }
light_source { <4, 6, -5> rgb 0.9 }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
sphere { 0, 0.7 pigment { rgb <0.8, 0.25, 0.2> } finish { phong 0.6 phong_size 60 } }
box { <-1.6, -1, 0.2>, <-1, 0.5, 0.8> pigment { rgb <0.2, 0.35, 0.8> } finish { specular 0.5 roughness 0.03 } }
