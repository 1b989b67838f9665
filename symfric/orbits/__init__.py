"""Periodic orbits and their bifurcations."""
