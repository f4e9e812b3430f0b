//! Small glTF files, written by the tests.
