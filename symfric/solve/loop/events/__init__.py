"""Events: roots of guard polynomials, and what an event does to states and derivatives."""
