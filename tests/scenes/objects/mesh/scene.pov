// A mesh of flat triangles built by nested loops and a macro.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
#macro P(U, V) #local A = 2*pi*U/12; #local H = V/8; <(0.6+0.3*sin(6*H))*cos(A), 2*H-1, (0.6+0.3*sin(6*H))*sin(A)> #end
mesh {
  #local U = 0; #while (U < 12) #local V = 0; #while (V < 8)
    triangle { P(U, V), P(U+1, V), P(U+1, V+1) } triangle { P(U, V), P(U+1, V+1), P(U, V+1) }
  #local V = V+1; #end #local U = U+1; #end
  pigment { rgb <0.5, 0.7, 0.3> } finish { specular 0.3 } rotate 15*z
}
