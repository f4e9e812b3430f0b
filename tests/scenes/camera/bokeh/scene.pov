// The lens weighed by a pigment.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera {
  location <0, 0.4, -3> look_at <0, 0, 0> angle 50 right 4/3*x aperture 0.6 blur_samples 120 focal_point <0, 0, -0.6>
  bokeh { pigment { boxed color_map { [0.4 rgb 0] [0.4 rgb 1] } scale <0.5, 0.3, 1> translate <0.5, 0.5, 0> } }
}
plane { y, -1 pigment { checker rgb <0.85, 0.82, 0.75>, rgb <0.35, 0.4, 0.45> } finish { ambient 0.1 diffuse 0.7 } }
light_source { <3, 5, -3> rgb 1 }
sphere { 0, 0.7 pigment { rgb <0.8, 0.25, 0.2> } finish { phong 0.6 phong_size 60 } }
// Sparks out of focus, each a picture of the lens.
#for (I, -2, 2) sphere { <I*0.9, 1 - 0.1*I*I, 3>, 0.06 pigment { rgb <1, 0.7, 0.4> } finish { ambient 20 diffuse 0 } } #end
