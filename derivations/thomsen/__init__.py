"""Thomsen's paper, equation by equation, in the order of its sections.

============  ==================================================  ===========
`model`       2: letters, equation of motion, friction function   (1)-(6)
`pure_slip`   3.1, 3.2: steady sliding, averaging, pure slip      (7)-(22)
`stick_slip`  3.3, 3.4: stick-slip, summary                       (23)-(30)
`accuracy`    2.3, 3.4: how good what is called good is
`separation`  4.1: slow and fast motion                           (31)-(42)
`effective`   4.1: effective friction                             (43)-(50)
`quenching`   4.2, 5: stability under fast excitation, quenching  (51)-(58)
`energy`      5.3, 5.4: what quenching costs                      (59)-(61)
`outlook`     after (56), (58): what the paper leaves to others
============  ==================================================  ===========
"""

from derivations.ledger import joined
from derivations.thomsen import (
    accuracy,
    effective,
    energy,
    model,
    outlook,
    pure_slip,
    quenching,
    separation,
    stick_slip,
)

LEDGER = joined(
    "thomsen",
    "J. J. Thomsen, Using fast vibrations to quench friction-induced oscillations, J. Sound Vib. 228 (1999) 1079-1102",
    model,
    pure_slip,
    stick_slip,
    accuracy,
    separation,
    effective,
    quenching,
    energy,
    outlook,
)
