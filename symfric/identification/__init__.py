"""Friction laws and other values of a scene from measured records."""
