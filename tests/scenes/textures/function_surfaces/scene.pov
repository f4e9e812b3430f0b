// Algebraic surfaces among the built-in functions, as pigments.
#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { orthographic location <0, 0, -5> right 4*x up 3*y look_at 0 }
#declare B8 = function { internal(8) }
box { <-0.6, -0.45, 0>, <0.6, 0.45, 1> pigment { function { 0.5 + 0.3*atan2(B8(x*3, y*3, 0.3 + 0.2*x, 1, 0.02), 1) } color_map { [0 rgb <0.1, 0.2, 0.6>] [0.5 rgb 1] [1 rgb <0.7, 0.2, 0.1>] } } finish { ambient 1 diffuse 0 } translate <-1.3, 0.95, 0> }
#declare B16 = function { internal(16) }
box { <-0.6, -0.45, 0>, <0.6, 0.45, 1> pigment { function { 0.5 + 0.3*atan2(B16(x*3, y*3, 0.3 + 0.2*x, 1, 1.2, 0.3, 0.5, 0.4, 1.5), 1) } color_map { [0 rgb <0.1, 0.2, 0.6>] [0.5 rgb 1] [1 rgb <0.7, 0.2, 0.1>] } } finish { ambient 1 diffuse 0 } translate <0.0, 0.95, 0> }
#declare B35 = function { internal(35) }
box { <-0.6, -0.45, 0>, <0.6, 0.45, 1> pigment { function { 0.5 + 0.3*atan2(B35(x*3, y*3, 0.3 + 0.2*x, 0.3), 1) } color_map { [0 rgb <0.1, 0.2, 0.6>] [0.5 rgb 1] [1 rgb <0.7, 0.2, 0.1>] } } finish { ambient 1 diffuse 0 } translate <1.3, 0.95, 0> }
#declare B40 = function { internal(40) }
box { <-0.6, -0.45, 0>, <0.6, 0.45, 1> pigment { function { 0.5 + 0.3*atan2(B40(x*3, y*3, 0.3 + 0.2*x, 0.5, 0.6, 1, 0.2, 1), 1) } color_map { [0 rgb <0.1, 0.2, 0.6>] [0.5 rgb 1] [1 rgb <0.7, 0.2, 0.1>] } } finish { ambient 1 diffuse 0 } translate <-1.3, 0.0, 0> }
#declare B44 = function { internal(44) }
box { <-0.6, -0.45, 0>, <0.6, 0.45, 1> pigment { function { 0.5 + 0.3*atan2(B44(x*3, y*3, 0.3 + 0.2*x, 0.1, 0.9, 0.8, 3), 1) } color_map { [0 rgb <0.1, 0.2, 0.6>] [0.5 rgb 1] [1 rgb <0.7, 0.2, 0.1>] } } finish { ambient 1 diffuse 0 } translate <0.0, 0.0, 0> }
#declare B64 = function { internal(64) }
box { <-0.6, -0.45, 0>, <0.6, 0.45, 1> pigment { function { 0.5 + 0.3*atan2(B64(x*3, y*3, 0.3 + 0.2*x, 0.7, 0.3, 2, 0, 0, 1), 1) } color_map { [0 rgb <0.1, 0.2, 0.6>] [0.5 rgb 1] [1 rgb <0.7, 0.2, 0.1>] } } finish { ambient 1 diffuse 0 } translate <1.3, 0.0, 0> }
#declare B28 = function { internal(28) }
box { <-0.6, -0.45, 0>, <0.6, 0.45, 1> pigment { function { 0.5 + 0.3*atan2(B28(x*3, y*3, 0.3 + 0.2*x, 1), 1) } color_map { [0 rgb <0.1, 0.2, 0.6>] [0.5 rgb 1] [1 rgb <0.7, 0.2, 0.1>] } } finish { ambient 1 diffuse 0 } translate <-1.3, -0.95, 0> }
#declare B52 = function { internal(52) }
box { <-0.6, -0.45, 0>, <0.6, 0.45, 1> pigment { function { 0.5 + 0.3*atan2(B52(x*3, y*3, 0.3 + 0.2*x, 5, 0.7, 0.1, 0, 0, 0), 1) } color_map { [0 rgb <0.1, 0.2, 0.6>] [0.5 rgb 1] [1 rgb <0.7, 0.2, 0.1>] } } finish { ambient 1 diffuse 0 } translate <0.0, -0.95, 0> }
#declare B72 = function { internal(72) }
box { <-0.6, -0.45, 0>, <0.6, 0.45, 1> pigment { function { 0.5 + 0.3*atan2(B72(x*3, y*3, 0.3 + 0.2*x, 0.1), 1) } color_map { [0 rgb <0.1, 0.2, 0.6>] [0.5 rgb 1] [1 rgb <0.7, 0.2, 0.1>] } } finish { ambient 1 diffuse 0 } translate <1.3, -0.95, 0> }
