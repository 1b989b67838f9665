"""Evidence for symfric: a benchmark with other packages, a stress test, and the figures of the sources anew.

A package of its own, which symfric never imports: the command line runs its commands where it is found.
"""
