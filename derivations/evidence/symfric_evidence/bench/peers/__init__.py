"""Solvers of other packages, and the package's own routes, on the problems of the benchmark."""
