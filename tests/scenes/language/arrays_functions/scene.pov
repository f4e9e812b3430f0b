// Arrays, loops, splines and user functions place and colour things.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
#declare Path = spline { natural_spline 0, <-1.6, -0.7, 0> 0.33, <-0.6, 0.8, 0.4> 0.66, <0.5, -0.4, -0.6> 1, <1.5, 0.6, 0.2> }
#declare Tint = array[3] { <0.9, 0.3, 0.2>, <0.2, 0.5, 0.9>, <0.9, 0.8, 0.3> }
#declare Size = function(q) { 0.1 + 0.12*abs(sin(7*q)) }
#for (I, 0, 24) sphere { Path(I/24), Size(I/24) pigment { rgb Tint[mod(I, 3)] } finish { phong 0.5 } } #end
