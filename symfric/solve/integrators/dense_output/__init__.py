"""Motion between the nodes of an integrator."""
