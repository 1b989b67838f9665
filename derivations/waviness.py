"""Mass on a belt with waves: Thomsen's section 5.4, "surface roughness with a period in space", carried out.

The slip w = v_b - x' runs through the phase phi = k (x - v_b t), phi' = -k w. Letters: h = F/k, W the energy of the
fast motion. Means over the phase are J_n = <w^n>; those in time are <w^(n-1)>/<1/w>, since dt = dphi/(k w).
"""

import mpmath as mp
import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import agree
from symfric.model import scenes
from symfric.theory import waviness

LEDGER = Ledger(
    "waviness",
    "Waves of the belt as excitation (J. J. Thomsen 1999, section 5.4, outlook); formulas as `symfric.theory.waviness` "
    "has them.",
)

v_b, beta, gamma2, F, k, mu_s, mu_m, v_m = waviness.SYMBOLS
h, W, phi, w = sp.symbols("h W phi w", positive=True)
J = {n: sp.Symbol(f"J{'m' if n < 0 else ''}{abs(n)}", positive=True) for n in (-1, 1)}  # <1/w>, <w>
ETA = sp.Rational(3, 2) * gamma2 * (mu_s - mu_m) / v_m
ONSET2 = v_m**2 * (1 - 2 * beta / ETA)
WAVE = [0, 0.03, 0.3, mp.pi / 2, mp.pi]  # half a wave, finer at the hill, where the mass is slow
CASES = ((0.45, 0.1), (0.3, 0.05))  # belt speed and h


@LEDGER.verified(
    "fast motion",
    "slip over a wave without spring, damper and friction: dw/dphi along x'' = F sin(phi)",
    F * sp.sin(phi) / (k * w),
)
def _(claim):
    energy = w**2 / 2 + F / k * sp.cos(phi)  # constant
    return sp.simplify(-energy.diff(phi) / energy.diff(w) - claim)


@LEDGER.verified(
    "mean slip",
    "v_b with m = 2 h/(W + h)",
    sp.pi / 2 * sp.sqrt(2 * (W + h)) / sp.elliptic_k(2 * h / (W + h)),
    numbers="20 digits at two energies",
)
def _(claim):
    left = []
    for energy, hill in ((mp.mpf("0.3"), mp.mpf("0.1")), (mp.mpf("0.21"), mp.mpf("0.2"))):
        with mp.workdps(30):
            rate = mp.quad(lambda p, E=energy, H=hill: 1 / mp.sqrt(2 * (E - H * mp.cos(p))), [0, mp.pi]) / mp.pi
            left.append(agree(sp.Float(1 / rate, 30), claim.subs({W: sp.Float(energy, 30), h: sp.Float(hill, 30)}), 20))
    return left


@LEDGER.verified(
    "mean force",
    "of the belt on the mass, by the power v_b f that friction and damper take; mu = mean of mu over the phase",
    gamma2 * sp.Symbol("mu") + 2 * beta * (J[1] - v_b),
)
def _(claim):
    mu = sp.Symbol("mu")
    friction = gamma2 * mu / J[-1]  # mean of w mu in time
    damper = 2 * beta * (J[1] / J[-1] - v_b**2)  # mean of x'^2 = w^2 - 2 w v_b + v_b^2 in time
    return sp.simplify(((friction + damper) / v_b - claim).subs(J[-1], 1 / v_b))


@LEDGER.verified(
    "limit of stability",
    "v_b <w> where the force of the belt on a slow mass stops falling with the speed, damper included, for (5)",
    ONSET2,
)
def _(claim):
    # d/dv_b of gamma2 <mu(w)> + 2 beta <w> vanishes with its derivative by W, in which dw/dW = 1/w
    s = sp.Symbol("s", positive=True)
    law = mu_s - sp.Rational(3, 2) * (mu_s - mu_m) * (s / v_m - (s / v_m) ** 3 / 3)
    slope = sp.expand((gamma2 * law.diff(s) + 2 * beta) / s)
    mean = slope.coeff(s, -1) * J[-1] + slope.coeff(s, 1) * J[1]
    (found,) = sp.solve(mean.subs(J[-1], 1 / v_b), J[1])
    return sp.simplify(v_b * found - claim)


@LEDGER.verified(
    "limit of stability, exactly",
    "mean square of the slip in time where areas about the forced motion of the full model neither grow nor shrink",
    ONSET2,
)
def _(claim):
    # ln det Phi = -int (2 beta + gamma2 mu'(w)) dt, Liouville, as long as the slip keeps its sign
    law = mu_s - sp.Rational(3, 2) * (mu_s - mu_m) * (w / v_m - (w / v_m) ** 3 / 3)
    square = sp.Symbol("square", positive=True)
    (found,) = sp.solve(sp.expand(2 * beta + gamma2 * law.diff(w)).subs(w**2, square), square)
    return sp.simplify(found - claim)


@LEDGER.verified(
    "weak waves",
    "v_b <w> to h^2: (55) with q = h/v_b; the largest v_b at the limit, squared",
    v_b**2 + h**2 / (2 * v_b**2),
    (ONSET2 + sp.sqrt(ONSET2**2 - 2 * h**2)) / 2,
)
def _(square, limit):
    # w = sqrt(2 W) sqrt(1 - y), y = h cos(phi)/W, with <y> = 0 and <y^2> = h^2/(2 W^2) =: 2 d
    y, d = sp.symbols("y d", positive=True)

    def mean(function):
        parts = sp.series(function, y, 0, 3).removeO()
        return parts.coeff(y, 0) + 2 * d * parts.coeff(y, 2)

    slip, rate = sp.sqrt(2 * W) * mean(sp.sqrt(1 - y)), mean(1 / sp.sqrt(1 - y)) / sp.sqrt(2 * W)
    left = slip / rate - square.subs(h**2, 4 * d * W**2).subs(v_b, 1 / rate)
    root = waviness.sinusoidal_onset_speed(symbolic=True) ** 2
    return (
        sp.simplify(left.subs(d, 0)),
        sp.simplify(left.diff(d).subs(d, 0)),
        sp.expand(limit**2 - ONSET2 * limit + h**2 / 2),
        sp.expand(root - limit.subs(h, F / k)),
    )


@LEDGER.verified(
    "numbers",
    "limit of stability with h = .1 and .3, figure 3's values; force, slip on the hill, v_b, h = .45, .1 and .3, .05",
    *(sp.Float(waviness.onset_speed(scenes.wavy_belt(v_b=0.3, F=100.0 * hill, k=100.0))) for hill in (0.1, 0.3)),
    *(
        sp.Float(e)
        for v, hill in CASES
        for e in (
            waviness.drag(scenes.wavy_belt(v_b=v, F=100.0 * hill, k=100.0)),
            waviness.slip_over_a_wave(v, hill, 1001)[0],
        )
    ),
    numbers="10 digits, by quadrature over a wave",
)
def _(*claim):
    def mean(function, energy, hill):
        return mp.quad(lambda p: function(mp.sqrt(2 * (energy - hill * mp.cos(p)))), WAVE) / mp.pi

    found = []
    limit = (1 - mp.mpf("0.1") / mp.mpf("0.45")) / 4
    for hill in (mp.mpf("0.1"), mp.mpf("0.3")):

        def excess(rest, hill=hill):
            energy = hill + mp.exp(rest)
            return mean(lambda s: s, energy, hill) / mean(lambda s: 1 / s, energy, hill) - limit

        rest = mp.findroot(excess, (-12, 2), solver="anderson", tol=1e-24)
        found.append(1 / mean(lambda s: 1 / s, hill + mp.exp(rest), hill))
    for speed, hill in CASES:
        v, height = mp.mpf(str(speed)), mp.mpf(str(hill))

        def gap(rest, v=v, height=height):
            return 1 / mean(lambda s: 1 / s, height + mp.exp(rest), height) - v

        energy = height + mp.exp(mp.findroot(gap, (-12, 2), solver="anderson", tol=1e-24))
        friction = mean(lambda s: mp.mpf("0.4") - mp.mpf("0.45") * s + mp.mpf("0.6") * s**3, energy, height)
        found.append(friction + mp.mpf("0.1") * (mean(lambda s: s, energy, height) - v))
        found.append(mp.sqrt(2 * (energy - height * mp.cos(mp.pi / 1001))))
    return [agree(sp.Float(f, 20), c, digits=10) for f, c in zip(found, claim, strict=True)]
