"""Thomsen's mass on a moving belt: what the paper leaves to others, carried out: ranges of speeds, excited cycles."""

import mpmath as mp
import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import agree
from derivations.thomsen.effective import effective
from derivations.thomsen.model import friction, mu_s, v_1
from derivations.thomsen.quenching import V, crossing, limits
from derivations.thomsen.separation import q, v_r
from symfric.model import scenes
from symfric.theory import belt

PART = Ledger("thomsen", "5.2, 5.4: outlook")


# --- 5.2 "quenching at belt speeds above a certain value, or within a range" ---------------------------------------
# Of the two intensities that quench a speed V the smaller one counts; V rises, the other one falls, and they meet at
# a Omega*. Over a range the largest of the smaller ones is therefore at the speed of the range nearest to a Omega*.
@PART.verified(
    "after (58) range",
    "intensity that quenches all belt speeds from low to high: both below a Omega*, around it, both above, above v_b1",
    *(e for e, _ in belt.quench_intensity_for(symbolic=True).args),
    numbers="the package's form at four ranges, exactly",
)
def _(*claim):
    unit = {v_1: 1}
    first, second = limits()
    star = crossing().subs(unit)
    low, high = sp.symbols("v_low v_high", positive=True)
    onset = belt.onset_speed(symbolic=True)
    # a law whose v_b1 is 1: no damping, v_m = 1
    plain = {**dict.fromkeys(belt.SYMBOLS, 1), belt.SYMBOLS.beta: 0, belt.SYMBOLS.mu_m: sp.Rational(1, 2)}
    left = [onset.subs(plain) - 1]
    for part, ends in zip(claim, ((2, 5), (6, 9), (9, 12), (12, 14)), strict=True):
        speeds = [sp.Rational(n, 10) for n in ends]
        inside = min(max(star, speeds[0]), speeds[1])
        both = (first.subs(V, inside), second.subs(unit).subs(V, inside)) if inside < 1 else (sp.Integer(0),)
        expected = min(both)
        given = {low: speeds[0], high: speeds[1], **plain}
        left += [e.subs(given) - expected for e in (sp.sympify(part), belt.quench_intensity_for(symbolic=True))]
    return [sp.nsimplify(sp.simplify(e)) for e in left]


@PART.verified(
    "after (58) numbers",
    "intensities for (.38, .5) and for all speeds above .42, figure 3's values",
    *(
        sp.Float(belt.quench_intensity_for(scenes.mass_on_belt(v_b=0.3), ends))
        for ends in ((0.38, 0.5), (0.42, float("inf")))
    ),
    numbers="12 digits",
)
def _(*claim):
    onset = sp.Rational(1, 4) * (1 - sp.Rational(1, 10) / sp.Rational(9, 20))  # v_b1^2
    return [agree(sp.sqrt(2 * (onset - sp.Rational(n, 100) ** 2)), c) for n, c in zip((38, 42), claim, strict=True)]


# --- 5.4 "keep a Omega slightly larger than v_b": a Omega = k v_b ----------------------------------------------------
@PART.verified(
    "5.4 following",
    "square of the least k that leaves no unstable speed (55) from V on; the speed down to which k = 1 is enough",
    2 * (v_1**2 / V**2 - 1),
    sp.sqrt(sp.Rational(2, 3)) * v_1,
)
def _(square, speed):
    k = sp.Symbol("k", positive=True)
    unstable = v_1**2 - (k * V) ** 2 / 2 - V**2  # positive at an unstable speed above a Omega
    return sp.expand(unstable.subs(k**2, square)), sp.expand(unstable.subs(k, 1).subs(V, speed)), crossing() - speed


@PART.verified(
    "5.4 following, numbers",
    "share of the friction and mean power at v_b = .2 for a Omega = 1.05 v_b and for a Omega*, figure 3's values",
    *(
        sp.Float(e)
        for q in (0.21, belt.quench_intensity(scenes.mass_on_belt(v_b=0.2)))
        for shaken in [scenes.mass_on_belt(v_b=0.2, a=q / 50, Omega=50.0)]
        for e in (belt.effective_friction(shaken)(0.2) / shaken.contacts[0].law(0.2), belt.mean_power(shaken))
    ),
    numbers="8 digits, by quadrature of (5) over the fast motion",
)
def _(*claim):
    v, found = mp.mpf("0.2"), []

    def force(w):
        return mp.sign(w) * (mp.mpf("0.4") - mp.mpf("0.225") * (2 * abs(w) - 8 * abs(w) ** 3 / 3))

    def mean(weight, intensity):
        edges = [0, mp.acos(v / intensity), mp.pi]
        return mp.quad(lambda angle: weight(angle) * force(v - intensity * mp.cos(angle)), edges) / mp.pi

    for intensity in (mp.mpf("0.21"), mp.sqrt(mp.mpf(2) / 3 * (1 - mp.mpf("0.1") / mp.mpf("0.45"))) / 2):
        found += [mean(lambda _: 1, intensity) / force(v)]
        found += [intensity**2 / 20 - intensity * mean(mp.cos, intensity)]
    return [agree(sp.Float(f, 20), c, digits=8) for f, c in zip(found, claim, strict=True)]


# --- After (56): cycles that enter |v_r| < a Omega ------------------------------------------------------------------
# There the effective friction is below the cubic of (47) line 2 by (2 mu_s/pi) acos(v_r/q), and 2 mu_s beyond -q.
@PART.verified(
    "after (56) inside",
    "(47) line 2, continued, less line 1",
    2 * mu_s / sp.pi * sp.acos(v_r / q),
)
def _(claim):
    outside = friction(v_r, 1) + effective(1) - friction(v_r, 1)
    return sp.expand((outside - effective(0) - claim).replace(sp.asin, lambda e: sp.pi / 2 - sp.acos(e)))


@PART.verified(
    "after (56) growth",
    "averaged A' of a cycle that enters |v_r| < a Omega: v_b = .3, a Omega = .2, A = .12 and .3",
    *(sp.Float(belt.excited_growth(scenes.mass_on_belt(v_b=0.3, a=0.004, Omega=50.0), size)) for size in (0.12, 0.3)),
    numbers="8 digits, by quadrature of (13) with (47)",
)
def _(*claim):
    def law(w):
        size, intensity = abs(w), mp.mpf("0.2")
        cubic = -mp.mpf("0.45") * size + mp.mpf("0.6") * (size**3 + 3 * intensity**2 * size / 2)
        jump = mp.mpf("0.4") * (2 / mp.pi * mp.asin(size / intensity) if size < intensity else 1)
        return mp.sign(w) * (jump + cubic)

    left = []
    for size, c in zip((mp.mpf("0.12"), mp.mpf("0.3")), claim, strict=True):
        with mp.workdps(20):
            v = mp.mpf("0.3")

            def force(psi, size=size, v=v):
                u = size * mp.cos(psi)
                return (u / 10 + law(u - v) + law(v)) * mp.cos(psi)

            edges = [0, *(mp.acos((v + s) / size) for s in (-mp.mpf("0.2"), mp.mpf("0.2")) if abs(v + s) < size)]
            edges = sorted({*edges, mp.pi / 2, mp.pi})
            found = -mp.quad(force, edges) / mp.pi
        left.append(agree(sp.Float(found, 20), c, digits=8))
    return left


@PART.verified(
    "after (56) cycle",
    "half the range of the slow cycle that enters |v_r| < a Omega: v_b = .3, a Omega = .2, in 1e-7",
    1240374,
    numbers="limit cycle of (40) with (47) by an integrator",
)
def _(claim):
    from scipy.integrate import solve_ivp

    scene = scenes.mass_on_belt(v_b=0.3, a=0.004, Omega=50.0)
    law = belt.effective_friction(scene)
    rest = law(0.3)

    def field(_t, y):
        return y[1], -0.1 * y[1] - y[0] - law(y[1] - 0.3) - rest

    run = solve_ivp(field, (0, 400), [0.3, 0.0], "LSODA", rtol=1e-9, atol=1e-11, dense_output=True)
    t = [380 + k / 1000 for k in range(14000)]
    x = run.sol(t)[0]
    half = 0.5 * (max(x) - min(x))
    package = belt.excited_amplitude(scene)
    return round(1e7 * package) - claim, int(abs(package - half) > 2e-6)
