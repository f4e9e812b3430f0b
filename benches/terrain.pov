// Hills of 281,250 triangles for `rayloom bench accel benches/terrain.pov`: seen from low above, so that rays pass many crests.
#version 3.7;
global_settings { assumed_gamma 1 }
camera { location <-1, 2.2, -1.5> look_at <5, 0, 5> angle 60 }
light_source { <20, 30, -10> rgb 1 }
#declare N = 375;
#macro Height(A, B)
  sin(7 * A) * cos(9 * B) + 0.1 * sin(90 * A * B) + 0.05 * sin(61 * A + 47 * B)
#end
mesh2 {
  vertex_vectors {
    (N + 1) * (N + 1)
    #for (J, 0, N) #for (I, 0, N)
      , <10 * I / N, Height(I / N, J / N), 10 * J / N>
    #end #end
  }
  face_indices {
    2 * N * N
    #for (J, 0, N - 1) #for (I, 0, N - 1)
      , <J * (N + 1) + I, J * (N + 1) + I + 1, (J + 1) * (N + 1) + I>
      , <J * (N + 1) + I + 1, (J + 1) * (N + 1) + I + 1, (J + 1) * (N + 1) + I>
    #end #end
  }
  pigment { rgb <0.6, 0.5, 0.3> }
}
