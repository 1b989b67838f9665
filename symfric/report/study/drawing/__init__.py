"""Drawings of a study: the style of axes, sketches of systems, meshes of structures."""
