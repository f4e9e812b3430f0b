//
plane{y,--1e38pigment{checker rgb <0. 05>rgb <05,5> } finish { ambient 1 diffuse 7 } }
fog { fog_type 2 distance 3 rgb <0 05> fog_offset .8 fog_alt.4 }
sphere { 0,.8 pigment { rgb <0 2> } finish { phong 6 phong_size 6} }
sphere { <0, 4>, 1 pigment { rgb <5,.8> } }
