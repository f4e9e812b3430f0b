// Thirty calls of noise in three functions, one of them of a pigment: more than renderers in software write out, so that shaders interpret them.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <0, 2.2, -6.5> look_at <0, 0.1, 0> angle 42 right 4/3*x }
light_source { <8, 12, -9> rgb 1 }
#declare N = function { internal(76) }
#declare Spots = function { pigment { gradient y pigment_map { [0 bozo scale 0.4] [0.5 rgb <0.2, 0.5, 0.8>] [1 agate scale 0.5] } scale 2 } }
#declare F0 = function { sin(1.000*N(x*1.37 + 1, y*1.23, z*1.51)) + (0.500*N(x*1.74 + 2, y*1.57, z*1.91)) + (0.333*N(x*2.11 + 3, y*1.9, z*2.32)) + sin(0.250*N(x*2.48 + 4, y*2.23, z*2.73)) + (0.200*N(x*2.85 + 5, y*2.56, z*3.14)) + (0.167*N(x*3.22 + 6, y*2.9, z*3.54)) + sin(0.143*N(x*3.59 + 7, y*3.23, z*3.95)) + (0.125*N(x*3.96 + 8, y*3.56, z*4.36)) + (0.111*N(x*4.33 + 9, y*3.9, z*4.76)) + sin(0.100*N(x*4.7 + 10, y*4.23, z*5.17)) }
#declare F1 = function { (1.000*N(x*5.07 + 11, y*4.56, z*5.58)) + sin(0.500*N(x*5.44 + 12, y*4.9, z*5.98)) + (0.333*N(x*5.81 + 13, y*5.23, z*6.39)) + (0.250*N(x*6.18 + 14, y*5.56, z*6.8)) + sin(0.200*N(x*6.55 + 15, y*5.89, z*7.21)) + (0.167*N(x*6.92 + 16, y*6.23, z*7.61)) + (0.143*N(x*7.29 + 17, y*6.56, z*8.02)) + sin(0.125*N(x*7.66 + 18, y*6.89, z*8.43)) + (0.111*N(x*8.03 + 19, y*7.23, z*8.83)) + (0.100*N(x*8.4 + 20, y*7.56, z*9.24)) }
#declare F2 = function { (1.000*N(x*8.77 + 21, y*7.89, z*9.65)) + (0.500*N(x*9.14 + 22, y*8.23, z*10.05)) + sin(0.333*N(x*9.51 + 23, y*8.56, z*10.46)) + (0.250*N(x*9.88 + 24, y*8.89, z*10.87)) + (0.200*N(x*10.25 + 25, y*9.22, z*11.28)) + sin(0.167*N(x*10.62 + 26, y*9.56, z*11.68)) + (0.143*N(x*10.99 + 27, y*9.89, z*12.09)) + (0.125*N(x*11.36 + 28, y*10.22, z*12.5)) + sin(0.111*N(x*11.73 + 29, y*10.56, z*12.9)) + (0.100*N(x*12.1 + 30, y*10.89, z*13.31)) }
plane { y, -1 pigment { function { F0(x, y, z)*0.4 } color_map { [0 rgb <0.1, 0.2, 0.4>] [0.5 rgb <0.8, 0.7, 0.4>] [1 rgb 1] } } }
sphere { <-1.6, 0, 0>, 1 pigment { function { F1(x, y, z)*0.4 } color_map { [0 rgb <0.6, 0.1, 0.1>] [1 rgb <1, 0.9, 0.6>] } } }
box { <0.4, -1, -0.8>, <2.2, 0.8, 0.8> pigment { function { F2(x, y, z)*0.3 + Spots(x, y, z).red*0.5 + sum(i, 1, 3, sin(i*x)/i)*0.1 } color_map { [0 rgb <0.1, 0.3, 0.1>] [1 rgb <0.8, 1, 0.5>] } } }
