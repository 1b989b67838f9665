"""Figures and tables of the sources, reproduced."""
