"""Optimal control through stick and slip."""
