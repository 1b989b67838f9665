"""Guida, Nilvetti and Pappalardo (2009): one slide that a drive draws over a way, and two slides in friction.

To be read in the order `drawn`, `stop`, `error` for the one, `slides`, `figures` for the two.
"""

from derivations.guida import drawn, error, figures, slides, stop
from derivations.ledger import Ledger

LEDGER = Ledger(
    "guida",
    "Guida, Nilvetti, Pappalardo, Instability induced by dry friction, Int. J. of Mechanics 3(3), 2009, 44-51",
    [entry for part in (drawn, stop, error, slides, figures) for entry in part.PART.entries],
)
