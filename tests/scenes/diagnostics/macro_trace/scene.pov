// An error in a macro says who called it.
#version 3.7;
#macro Inner(X) sphere { 0, X Y } #end
#macro Outer() Inner(2) #end
Outer()
