"""Lowering from SymPy to CasADi: a scene becomes a hybrid automaton of smooth functions with the mode as data."""
