"""Optimal control of systems with stick and slip."""
