// An include file that is nowhere.
#version 3.7;
#include "no_such_file.inc"
