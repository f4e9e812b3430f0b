// A word that is misspelt.
#version 3.7;
sphere { 0, 1 pigmnt { rgb 1 } }
