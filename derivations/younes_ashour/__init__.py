"""Younes and Ashour: a rod on a spring, braked by a contact whose friction falls with the sliding speed.

To be read in the order `system`, `amplitude`, `record`, `results`.
"""

from derivations.ledger import joined
from derivations.younes_ashour import amplitude, record, results, system

LEDGER = joined(
    "younes_ashour",
    "Younes and Ashour, Experimental and theoretical investigation of damping potential of system-dependent "
    "tribological contacts undergoing transient motion",
    system,
    amplitude,
    record,
    results,
)
