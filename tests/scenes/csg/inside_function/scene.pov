// inside() and trace() place balls on a body.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.0, -4.2> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
#declare O = difference { sphere { 0, 0.9 } box { 0, 2 } }
object { O pigment { rgb <0.8, 0.25, 0.2> } finish { phong 0.6 phong_size 60 } }
#for (I, 0, 40) #declare N = <0, 0, 0>; #declare P = trace(O, <sin(I*2.4)*2, 2*cos(I*1.1), -3>, <-sin(I*2.4)*2, -2*cos(I*1.1), 3>, N); #if (vlength(N) > 0) sphere { P, 0.07 pigment { rgb <0.8, 0.65, 0.2> } } #end #end
#if (inside(O, <0, 0, -0.5>)) box { <1.2, -1, -0.6>, <1.6, -0.6, -0.2> pigment { rgb <0.2, 0.35, 0.8> } finish { specular 0.5 roughness 0.03 } } #end
