// A brass orrery on a wooden table: CSG, tori, glass, noise textures, reflection, a sky. rayloom's first picture.
// -w960 -h600 +a0.1 +am2
#version 3.7;
global_settings { assumed_gamma 1.0 max_trace_level 8 }

camera { location <-4.2, 5.0, -11.6> look_at <0.05, 0.75, 0> angle 46 right 1.6*x }
light_source { <9, 14, -9> rgb <1, 0.95, 0.86> * 1.1 }
light_source { <-12, 7, -4> rgb <0.2, 0.24, 0.34> shadowless }

sky_sphere {
  pigment { gradient y color_map { [0 rgb <0.95, 0.86, 0.72>] [0.35 rgb <0.42, 0.58, 0.82>] [1 rgb <0.12, 0.25, 0.5>] } }
  pigment { bozo turbulence 0.7 omega 0.55 color_map { [0.45 rgbt 1] [0.75 rgbt <1, 0.98, 0.95, 0.35>] } scale <0.5, 0.16, 0.5> }
}

#declare Brass = texture {
  pigment { rgb <0.78, 0.55, 0.22> }
  finish { ambient 0.08 diffuse 0.35 brilliance 2 metallic specular 0.7 roughness 0.02 reflection { 0.28 metallic } }
}
#declare Walnut = texture {
  pigment {
    wood turbulence 0.05 octaves 3 scale 0.3 rotate <2, 86, 3>
    color_map { [0 rgb <0.36, 0.2, 0.1>] [0.55 rgb <0.3, 0.16, 0.08>] [0.9 rgb <0.16, 0.08, 0.04>] [1 rgb <0.36, 0.2, 0.1>] }
  }

  finish { ambient 0.1 diffuse 0.75 specular 0.25 roughness 0.04 reflection { 0.02, 0.14 } }
}

// The table: a slab with a rounded rim and an inlaid ring.
difference {
  union { cylinder { <0, -0.3, 0>, 0, 5.4 } torus { 5.4, 0.15 translate -0.15*y } }
  difference { cylinder { <0, -0.02, 0>, <0, 0.1, 0>, 4.6 } cylinder { <0, -0.1, 0>, <0, 0.2, 0>, 4.45 } texture { Brass } }
  texture { Walnut }
}
plane { y, -3 pigment { checker rgb <0.82, 0.78, 0.7>, rgb <0.28, 0.3, 0.34> scale 3 } finish { diffuse 0.6 reflection 0.06 } }

// Foot and axle.
union {
  difference { sphere { 0, 0.9 scale <1, 0.55, 1> } plane { y, 0 } }
  cone { <0, 0.4, 0>, 0.3, <0, 1.2, 0>, 0.08 }
  cylinder { <0, 1, 0>, <0, 2.5, 0>, 0.05 }
  #for (I, 0, 3) torus { 0.32 - 0.07*I, 0.035 translate (0.48 + 0.2*I)*y } #end
  texture { Brass }
}

#macro Arm(Radius, Height, Angle)
  union {
    cylinder { <0, Height, 0>, <Radius, Height, 0>, 0.03 }
    cylinder { <Radius, Height, 0>, <Radius, Height + 0.3, 0>, 0.02 }
    torus { 0.1, 0.03 translate Height*y }
    texture { Brass }
    rotate Angle*y
  }
#end
#macro Place(Radius, Height, Angle) rotate 0 translate <Radius, Height + 0.3, 0> rotate Angle*y #end

// The sun: onion glass around a glowing core.
sphere { <0, 2.65, 0>, 0.34 pigment { rgb <1, 0.75, 0.25> } finish { ambient 0 emission 0.9 diffuse 0.3 } normal { bumps 0.3 scale 0.06 } }
sphere { <0, 2.65, 0>, 0.52
  pigment { rgbf <1, 0.93, 0.8, 0.93> } finish { specular 0.9 roughness 0.004 reflection { 0.03, 1 fresnel } conserve_energy } interior { ior 1.3 } }

Arm(1.35, 1.3, 200)
sphere { 0, 0.2 texture { pigment { granite color_map { [0 rgb <0.3, 0.28, 0.26>] [1 rgb <0.85, 0.8, 0.75>] } scale 0.4 } finish { phong 0.2 } } Place(1.35, 1.5, 200) }
Arm(2.1, 1.42, 105)
sphere { 0, 0.31
  texture { pigment { agate agate_turb 0.6 scale 0.7 color_map { [0 rgb <0.75, 0.5, 0.25>] [0.5 rgb <0.95, 0.85, 0.65>] [1 rgb <0.6, 0.35, 0.2>] } } finish { phong 0.4 } }
  Place(2.1, 1.72, 105) }
Arm(2.95, 1.54, 242)
union {
  sphere { 0, 0.36
    texture { pigment { bozo turbulence 0.5 color_map { [0.45 rgb <0.07, 0.2, 0.5>] [0.5 rgb <0.2, 0.45, 0.2>] [0.75 rgb <0.55, 0.48, 0.3>] } scale 0.25 } finish { phong 0.7 phong_size 60 } }
    texture { pigment { wrinkles turbulence 0.4 color_map { [0.4 rgbt 1] [0.9 rgbt <1, 1, 1, 0.15>] } scale <0.4, 0.12, 0.4> } } }
  sphere { <0.55, 0.12, 0>, 0.1 pigment { rgb 0.7 } normal { dents 0.8 scale 0.05 } }
  torus { 0.55, 0.012 texture { Brass } }
  Place(2.95, 1.9, 242)
}
Arm(3.9, 1.66, 28)
union {
  sphere { 0, 0.42 pigment { gradient y turbulence 0.05 scale 0.3 color_map { [0 rgb <0.85, 0.75, 0.55>] [0.5 rgb <0.7, 0.55, 0.38>] [1 rgb <0.9, 0.82, 0.66>] } } finish { phong 0.3 } }
  disc { 0, y, 0.85, 0.52 pigment { onion scale 0.11 color_map { [0 rgbt <0.8, 0.7, 0.5, 0.1>] [0.7 rgbt <0.6, 0.5, 0.4, 0.4>] [1 rgbt <0.8, 0.7, 0.5, 0.9>] } } }
  rotate <0, 0, 18>
  Place(3.9, 2.0, 28)
}

// A magnifying lens left on the table, and a glass die.
merge {
  intersection { sphere { <0, 1.4, 0>, 1.5 } sphere { <0, -1.4, 0>, 1.5 }
    pigment { rgbf <0.97, 1, 0.98, 0.95> } finish { specular 0.8 roughness 0.003 reflection { 0.02, 1 fresnel } } interior { ior 1.5 } }
  torus { 0.54, 0.06 texture { Brass } }
  rotate 4*z translate <-2.3, 0.1, -2.6>
}
cone { <-2.75, 0.07, -2.95>, 0.07, <-3.9, 0.09, -3.75>, 0.11 texture { Walnut } }
difference {
  intersection { box { -0.4, 0.4 } sphere { 0, 0.56 } }
  #for (I, -1, 1) sphere { <0.24*I, 0.24*I, -0.42>, 0.07 } sphere { <0.42, 0.24*I, 0>, 0.07 } #end
  pigment { rgbf <0.55, 0.8, 0.75, 0.8> } finish { specular 0.9 roughness 0.005 reflection { 0.03, 1 fresnel } }
  interior { ior 1.45 fade_distance 0.8 fade_power 1 fade_color <0.2, 0.55, 0.5> }
  rotate 32*y translate <2.6, 0.4, -2.7>
}
