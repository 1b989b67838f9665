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
    8: (0.7567655609906, 0.3393254585885, 0.06663589850718),
    9: (0.7959883669183, 0.422537178624, 0.1311166610151, 0.01813139167413),
    10: (0.8343346099229, 0.4810668561278, 0.1645540175489, 0.0251856139317),
    11: (0.8589785954436, 0.5443613108349, 0.2307644220617, 0.05841984054747, 0.006718430251673),
    12: (0.8866467679636, 0.5984443764191, 0.2746342281644, 0.07573761014664, 0.009501773773443),
    13: (0.9026042741443, 0.6463034688783, 0.3365436481326, 0.1186849543809, 0.02540476560251, 0.002504370338128),
    14: (0.9223037885296, 0.6930802805103, 0.3851597316456, 0.1460949668385, 0.03372969536132, 0.003587665715589),
    15: (0.9368040817478, 0.7311293850172, 0.4285434442763, 0.1727709658937, 0.0425224921513, 0.004824273903873),
    16: (0.947717137009, 0.7623649158089, 0.4671503918847, 0.1983718762548, 0.05158340261792, 0.006187524349083),
    17: (0.9560919575917, 0.7882410828715, 0.5014908753507, 0.22271194072, 0.06075586209385, 0.007652017590272),
    18: (0.9626333006257, 0.8098749588442, 0.5320789113355, 0.2457179973533, 0.06992401882444, 0.009195318315756),
    19: (0.9678233447502, 0.8281194542241, 0.5593848318463, 0.2673806769049, 0.07900160068616, 0.01079771931714),
    20: (0.9720000494351, 0.8436334550467, 0.5838302357427, 0.2877333404575, 0.08792711223521, 0.01244250806001),
    21: (0.9754043676005, 0.8569278193618, 0.6057825104041, 0.3068319419578, 0.09665704111146, 0.01411552994696),
    22: (0.9782113933446, 0.8684028967004, 0.6255602265895, 0.3247456626785, 0.105162173915, 0.01580502921331),
    23: (0.9805502938516, 0.8783745219334, 0.6434371408258, 0.3415488143541, 0.1134236929969, 0.01750125628665),
    24: (0.9825178405865, 0.8870942346212, 0.6596485136891, 0.3573169871276, 0.1214307974075, 0.01919623005755),
    25: (0.9841874866225, 0.8947638341047, 0.67439614345, 0.3721239764379, 0.1291784958572, 0.02088343730888),
    26: (0.9856157051512, 0.9015465779152, 0.6878534762238, 0.3860404047521, 0.1366661625141, 0.02255762119934),
    27: (0.9868464064591, 0.9075754825972, 0.7001697521953, 0.3991327359995, 0.1438962921425, 0.02421456456512),
    28: (0.9879141040415, 0.9129597307361, 0.7114737480363, 0.4114629649272, 0.1508736480044, 0.02585092633998),
    29: (0.9888461911002, 0.9177895334194, 0.7218768447956, 0.4230884792253, 0.1576045600737, 0.02746408924282),
    30: (0.9896646115717, 0.9221399173237, 0.7314756794907, 0.434062180457, 0.1640964313444, 0.02905204029854),
}


def exact_order(order: int) -> int:
    """Return the order to which a weighted step is accurate; 0 for series that are not weighted."""
    return order - len(_WEIGHTS[order]) if order in _WEIGHTS else 0


def weights(order: int) -> np.ndarray:
    """Return the weights of all coefficients, shape (order + 1,)."""
    factors = np.ones(order + 1)
    factors[exact_order(order) + 1 :] = _WEIGHTS.get(order, 1.0)
    return factors
