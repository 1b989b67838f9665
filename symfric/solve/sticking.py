"""Which contacts stick along a run."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from symfric.solve.run import Run


def stuck(run: "Run") -> np.ndarray:
    """Return whether each contact sticks from each time of a run on, shape (n_contacts, n_t).

    A closed stop does not: it has no friction.
    """
    rubs = np.array([not c.frictionless for c in run.scene.contacts], dtype=bool)
    return (run.mode == 0) & rubs[:, None]
