"""From a scene to its motion: the routes, the choice between them, and the run they return."""
