// Penrose's three tilings: pentagons and stars on the floor, kites and darts on a sphere, rhombs on a box.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.6, -4.2> look_at <0, -0.1, 0> angle 46 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
#declare Six = color_map {
  [1/6 rgb <0.75, 0.3, 0.25>] [1/6 rgb <0.85, 0.8, 0.6>] [2/6 rgb <0.6, 0.55, 0.4>] [2/6 rgb <0.5, 0.6, 0.7>] [3/6 rgb <0.3, 0.4, 0.5>]
  [3/6 rgb <0.95, 0.8, 0.2>] [4/6 rgb <0.7, 0.5, 0.1>] [4/6 rgb <0.3, 0.5, 0.3>] [5/6 rgb <0.2, 0.35, 0.2>] [5/6 rgb 0.9] [1 rgb 0.5]
}
#declare Two = color_map { [0 rgb <0.9, 0.85, 0.7>] [0.5 rgb <0.5, 0.3, 0.2>] [0.5 rgb <0.3, 0.5, 0.75>] [1 rgb <0.05, 0.1, 0.2>] }
plane { y, -1 pigment { tiling 25 color_map { Six } scale 0.4 } finish { ambient 0.1 diffuse 0.7 } }
sphere { <-0.8, 0, 0>, 0.9 pigment { tiling 26 color_map { Two } scale 0.3 rotate -50*x } }
box { <0.3, -1, -0.5>, <1.6, 0.6, 0.7> pigment { tiling 27 color_map { Two } scale 0.25 rotate <-90, 10, 0> } normal { tiling 27 0.3 scale 0.25 } rotate 10*y }
