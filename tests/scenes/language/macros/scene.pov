// Macros, arrays, #for, #switch and rand.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
#declare N = 9;
#declare Colors = array[3] { rgb <0.8, 0.2, 0.2>, rgb <0.2, 0.7, 0.3>, rgb <0.2, 0.3, 0.8> }
#macro Ball(I, R)
  sphere { <1.1*cos(2*pi*I/N), 0.4*sin(4*pi*I/N), 1.1*sin(2*pi*I/N)>, R pigment { Colors[mod(I, 3)] } finish { phong 0.5 } }
#end
#for (I, 0, N-1) Ball(I, 0.18 + 0.12*mod(I, 2)) #end
#declare S = seed(7);
#switch (N) #case (9) cylinder { -1*y, y, 0.15 + 0.1*rand(S) pigment { rgb <0.8, 0.65, 0.2> } } #break #else box { -1, 1 } #end
