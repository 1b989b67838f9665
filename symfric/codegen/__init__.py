"""Generation of machine code from CasADi functions and numba loops, independent of mechanics."""
