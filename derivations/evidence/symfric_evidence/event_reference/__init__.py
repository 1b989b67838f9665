"""Reference simulator: event-driven integration independent of the package's solvers.

It reads the SymPy expressions of a scene by `sympy.lambdify`, integrates one mode at a time with SciPy, locates events
on a fine grid of the dense output and chooses the next mode by enumeration. It is slow and simple. The stress run takes
it as second opinion, which is why it is part of the package; the tests check it against closed forms.
"""

from symfric_evidence.event_reference.simulator import Reference, ReferenceSimulator

__all__ = ["Reference", "ReferenceSimulator"]
