"""Tuned mass dampers."""
