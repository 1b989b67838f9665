"""Machine code from CasADi functions and from compiled loops; knows no physics."""
