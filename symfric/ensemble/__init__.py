"""Many scenes, many cores, many machines: ground motions and sweeps."""
