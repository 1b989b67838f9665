"""Implicit integration of stiff laws with memory, with derivatives and without."""
