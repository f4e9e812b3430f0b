// What highlights, brilliance, bumps, films, backs and layers make of photons.
#version 3.7;
global_settings { assumed_gamma 1.0 photons { spacing 0.03 radius 0.2 } }
camera { location <0, 4, -6> look_at <0, -0.2, 0> angle 42 right 4/3*x }
plane { y, -1 texture { pigment { rgb <0.8, 0.6, 0.4> } finish { ambient 0.05 diffuse 0.7 } } texture { pigment { checker rgbf <0.3, 0.9, 0.5, 0.6> rgbt <0.9, 0.3, 0.4, 0.3> scale 0.5 } normal { bumps 0.3 scale 0.3 } finish { diffuse 0.5 brilliance 2 ambient 0 phong 0.4 specular 0.3 metallic irid { 0.3 thickness 0.5 } } } }
light_source { <3, 8, -2> rgb 0.9 }
sphere { 0, 1 pigment { rgbf <1, 0.98, 0.95, 0.9> } finish { ambient 0 diffuse 0.05 phong 0.4 } interior { ior 1.5 } photons { target refraction on } }
disc { <-1.2, -0.5, 0>, y, 0.7 pigment { rgb 1 } finish { ambient 0 diffuse 0.4, 0.5 } }
