"""Damping and friction of an isolated mass."""
