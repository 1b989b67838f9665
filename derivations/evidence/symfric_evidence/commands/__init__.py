"""The commands ``symfric bench``, ``stress`` and ``reproduce``."""
