"""Friction laws, mechanical systems, contacts and scenes: the SymPy layer, where every equation is written."""
