"""Branches of limit cycles, their special points, and curves of these."""
