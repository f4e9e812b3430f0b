// A mesh camera by uv: no holes along shared edges.
#version 3.7;
global_settings { assumed_gamma 1.0 }
#declare N = 8;
#declare M = mesh {
  #for (I, 0, N-1) #for (J, 0, N-1)
    #declare A = <I, J, 0>/N; #declare B = <I+1, J, 0>/N; #declare C = <I+1, J+1, 0>/N; #declare D = <I, J+1, 0>/N;
    smooth_triangle { A, -z, C, -z, B, -z uv_vectors <A.x, A.y>, <C.x, C.y>, <B.x, B.y> }
    smooth_triangle { A, -z, D, -z, C, -z uv_vectors <A.x, A.y>, <D.x, D.y>, <C.x, C.y> }
  #end #end
}
camera { mesh_camera { 1 3 mesh { M translate <-0.5, -0.5, 0> scale <4, 3, 1> translate -6*z } } location <0, 0, 0.01> direction z }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
light_source { <3, 5, -3> rgb 1 }
sphere { 0, 0.7 pigment { rgb <0.8, 0.25, 0.2> } finish { phong 0.6 phong_size 60 } }
plane { z, 5 pigment { marble scale 2 } }
