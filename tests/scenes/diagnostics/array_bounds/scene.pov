// An index beyond an array.
#version 3.7;
#declare A = array[2] { 1, 2 }
sphere { 0, A[2] }
