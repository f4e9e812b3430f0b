// Pavements: pieces of triangles on the floor, of squares on a sphere, of hexagons on a box; a row of what form, interior and exterior do.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <1.6, 2.6, -4.2> look_at <0, -0.1, 0> angle 46 right 4/3*x }
light_source { <4, 6, -5> rgb 0.9 }
light_source { <-5, 3, -2> rgb <0.25, 0.27, 0.35> shadowless }
#declare Two = color_map { [0 rgb <0.9, 0.85, 0.7>] [0.6 rgb <0.5, 0.3, 0.2>] [0.9 rgb <0.3, 0.5, 0.75>] [1 rgb <0.05, 0.1, 0.2>] }
plane { y, -1 pigment { pavement number_of_sides 3 number_of_tiles 6 pattern 5 form 2 interior 1 color_map { Two } scale 0.5 } finish { ambient 0.1 diffuse 0.7 } }
sphere { <-0.8, 0, 0>, 0.9 pigment { pavement number_of_sides 4 number_of_tiles 4 pattern 4 form 3 interior 2 exterior 1 color_map { Two } scale 0.2 rotate -50*x } }
box { <0.3, -1, -0.5>, <1.6, 0.6, 0.7> pigment { pavement number_of_sides 6 number_of_tiles 4 pattern 5 form 1 color_map { Two } scale 0.12 rotate <-90, 10, 0> }
      normal { pavement 0.3 number_of_sides 4 number_of_tiles 5 pattern 7 form 2 scale 0.2 } rotate 10*y }
#declare Kinds = array[5][5] { { 3, 5, 0, 0, 1 }, { 3, 4, 1, 0, 2 }, { 4, 3, 1, 0, 0 }, { 4, 4, 2, 0, 2 }, { 6, 3, 2, 2, 0 } }
#for (I, 0, 4)
  box { <-0.5, 0, -0.5>, <0.5, 0.05, 0.5> pigment { pavement number_of_sides Kinds[I][0] number_of_tiles Kinds[I][1] form Kinds[I][2] interior Kinds[I][3] exterior Kinds[I][4]
        pattern min(2, Kinds[I][1] - 1) color_map { Two } scale 0.17 } scale 0.8 translate <-1.8 + I*0.9, -1, -1.3> }
#end
