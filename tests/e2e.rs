//! Black-box tests: they drive the program named by `BIOTOPE_BIN`, or the one just built.
