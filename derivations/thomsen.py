"""Thomsen's paper, equation by equation, in the order of its sections.

=========================  ==================================================  ===========
`thomsen_pure_slip`        2 to 3.2: the model, averaging, pure slip           (1)-(22)
`thomsen_stick_slip`       3.3, 3.4: stick-slip, summary                       (23)-(30)
`thomsen_separation`       4.1: slow and fast motion, effective friction       (31)-(50)
`thomsen_quenching`        4.2, 5: stability under fast excitation, quenching  (51)-(61)
=========================  ==================================================  ===========

Each part enters its equations in the ledger of the first one when it is imported: hence the order of the imports.
"""

from derivations import thomsen_pure_slip, thomsen_stick_slip

# isort: split
from derivations import thomsen_quenching, thomsen_separation

LEDGER = thomsen_pure_slip.LEDGER

__all__ = ["LEDGER", "thomsen_pure_slip", "thomsen_quenching", "thomsen_separation", "thomsen_stick_slip"]
