"""Periodic motions and where they change their kind."""
