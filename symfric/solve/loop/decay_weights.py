"""Weights of the last coefficients of a Taylor series with which steps may be longer than fast decays allow.

Of a decay with the rate l, the end of a step h of order n is ``sum (-z)^k/k!``, k = 0 .. n, z = l h: beyond z of about
2 + .35 n it grows, however small the decaying part of a motion is. With weights of the coefficients it is

    R(-z) = sum g_k (-z)^k / k!,    g_k = 1 for k up to p < n,

accurate to order p, and the last n - p weights are those for which |R| stays below `DAMPED` up to the largest z: three
to four times as far. R touches this bound n - p + 1 times with changing signs, by which the weights were computed, and
are verified. A step that is weighted is still a polynomial in time, which bounds the decay within the step as well.

References
----------
Van der Houwen and Sommeijer, On the internal stability of explicit, m-stage Runge-Kutta methods for large m-values,
Zeitschrift fur Angewandte Mathematik und Mechanik 60 (1980) 479, for such polynomials of order 2.
"""

import numpy as np

DAMPED = 0.95  # largest part of a decaying term that a step leaves, once its z is above three
PREFERRED = 0.9  # a weighted step is taken if it is longer than this part of a plain one; else, z stays at its limit
LONGEST = 8.0  # most times the length of a plain one

# the last weights, by the order of the series
_WEIGHTS: dict[int, tuple[float, ...]] = {
    8: (0.75676556099, 0.33932545859, 0.06663589851),
    9: (0.79598836692, 0.42253717862, 0.13111666102, 0.01813139167),
    10: (0.83433460992, 0.48106685613, 0.16455401755, 0.02518561393),
    11: (0.85897859544, 0.54436131083, 0.23076442206, 0.05841984055, 0.00671843025),
    12: (0.88664676796, 0.59844437642, 0.27463422816, 0.07573761015, 0.00950177377),
    13: (0.90260427414, 0.64630346888, 0.33654364813, 0.11868495438, 0.02540476560, 0.00250437034),
    14: (0.92230378853, 0.69308028051, 0.38515973165, 0.14609496684, 0.03372969536, 0.00358766572),
    15: (0.93680408175, 0.73112938502, 0.42854344428, 0.17277096589, 0.04252249215, 0.00482427390),
    16: (0.94771713701, 0.76236491581, 0.46715039188, 0.19837187625, 0.05158340262, 0.00618752435),
    17: (0.95609195759, 0.78824108287, 0.50149087535, 0.22271194072, 0.06075586209, 0.00765201759),
    18: (0.96263330063, 0.80987495884, 0.53207891134, 0.24571799735, 0.06992401882, 0.00919531832),
    19: (0.96782334475, 0.82811945422, 0.55938483185, 0.26738067690, 0.07900160069, 0.01079771932),
    20: (0.97200004944, 0.84363345505, 0.58383023574, 0.28773334046, 0.08792711224, 0.01244250806),
    21: (0.97540436760, 0.85692781936, 0.60578251040, 0.30683194196, 0.09665704111, 0.01411552995),
    22: (0.97821139334, 0.86840289670, 0.62556022659, 0.32474566268, 0.10516217392, 0.01580502921),
    23: (0.98055029385, 0.87837452193, 0.64343714083, 0.34154881435, 0.11342369300, 0.01750125629),
    24: (0.98251784059, 0.88709423462, 0.65964851369, 0.35731698713, 0.12143079741, 0.01919623006),
    25: (0.98418748662, 0.89476383410, 0.67439614345, 0.37212397644, 0.12917849586, 0.02088343731),
    26: (0.98561570515, 0.90154657792, 0.68785347622, 0.38604040475, 0.13666616251, 0.02255762120),
    27: (0.98684640646, 0.90757548260, 0.70016975220, 0.39913273600, 0.14389629214, 0.02421456457),
    28: (0.98791410404, 0.91295973074, 0.71147374804, 0.41146296493, 0.15087364800, 0.02585092634),
    29: (0.98884619110, 0.91778953342, 0.72187684480, 0.42308847923, 0.15760456007, 0.02746408924),
    30: (0.98966461157, 0.92213991732, 0.73147567949, 0.43406218046, 0.16409643134, 0.02905204030),
}


def exact_order(order: int) -> int:
    """Return the order to which a weighted step is accurate; 0 for series that are not weighted."""
    return order - len(_WEIGHTS[order]) if order in _WEIGHTS else 0


def weights(order: int) -> np.ndarray:
    """Return the weights of all coefficients, shape (order + 1,)."""
    found = np.ones(order + 1)
    found[exact_order(order) + 1 :] = _WEIGHTS.get(order, 1.0)
    return found
