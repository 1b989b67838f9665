"""The numbers that the closed forms return: each against its formula, which the other files prove, or from scratch.

A function of ``symfric.theory`` may have a right formula and still return a wrong number. Here its number, as the
package returns it, is the claim; the check evaluates the formula, or what the formula was derived from, with 30 digits.
"""

from functools import cache, partial

import mpmath as mp
import sympy as sp

from derivations.ledger import Ledger
from derivations.residuals import agree
from symfric.design.absorber.classic import absorber as designed
from symfric.model import scenes
from symfric.theory import absorber, belt, drive, scaling, transient

LEDGER = Ledger("numbers", "The numbers that the closed forms of `symfric.theory` return, with 12 digits")
DIGITS = "12 digits"

# --- Mass on a belt ------------------------------------------------------------------------------------------------
# Belt speeds in stick-slip, in pure slip and under fast excitation. Other values than the sources' on purpose.
BELT = {"beta": "7/100", "gamma2": "11/10", "a": "1/100", "Omega": "30"}
LAW = {"mu_s": "9/20", "mu_m": "1/5", "v_m": "3/5"}
SLOW, FAST = "1/5", "13/25"
STICKS = {"release_position", "slip_arc", "slow_belt_amplitude", "stick_slip_amplitude", "stick_slip_frequency"}
SLIPS = {"pure_slip_amplitude", "pure_slip_frequency"}
ORDERS = {"stick_speed", "slow_belt_amplitude", "stick_slip_amplitude", "stick_slip_frequency", *SLIPS}
AT_SPEED = {"quench_intensity_at", "quench_intensity_below"}
EXCITED = {"excited_amplitude": "487/1000"}  # a belt speed at which the closed form holds
APART = {"SYMBOLS", "effective_friction", "energy_ratio", "excited_growth"}  # a law, no scene, and thomsen/outlook.py
RANGE = {"quench_intensity_for": (0.25, 0.5)}


def belt_scene(speed: str):
    from symfric.model import laws

    law = laws.cubic(*(float(sp.Rational(LAW[k])) for k in ("mu_s", "mu_m", "v_m")))
    values = {k: float(sp.Rational(v)) for k, v in BELT.items()}
    return scenes.mass_on_belt(law, v_b=float(sp.Rational(speed)), **values)


def numbers_of_belt(name: str, speed: str, arguments: dict) -> tuple[sp.Float, ...]:
    found = getattr(belt, name)(belt_scene(speed), **arguments)
    return tuple(sp.Float(e) for e in (found if isinstance(found, tuple) else (found,)))


def formula_of_belt(*claim, name: str, speed: str, arguments: dict):
    given = {"v_b": speed, **BELT, **LAW}
    at = {s: sp.Rational(given[s.name]) for s in belt.SYMBOLS}
    at |= {sp.Symbol("v_hat", positive=True): sp.Rational(str(arguments["v"]))} if "v" in arguments else {}
    if "speeds" in arguments:
        at |= dict(zip(sp.symbols("v_low v_high", positive=True), map(sp.Rational, arguments["speeds"]), strict=True))
    rest = {k: v for k, v in arguments.items() if k not in ("v", "speeds")}
    formula = getattr(belt, name)(symbolic=True, **rest)
    parts = formula if isinstance(formula, tuple) else (formula,)
    return [agree(e.subs(at), c) for e, c in zip(parts, claim, strict=True)]


def _belt_rows():
    for name in belt.__all__:
        if name in APART:
            continue
        speed = FAST if name in SLIPS else EXCITED.get(name, SLOW)
        for order in (1, 2) if name in ORDERS else (None,):
            arguments = {} if order is None else {"order": order}
            arguments |= {"v": 0.25} if name in AT_SPEED else {"speeds": RANGE[name]} if name in RANGE else {}
            shown = "".join(f", {k} = {v}" for k, v in arguments.items())
            LEDGER.verified(
                f"belt.{name}{shown}",
                f"at v_b = {speed}",
                *numbers_of_belt(name, speed, arguments),
                numbers=DIGITS,
            )(partial(formula_of_belt, name=name, speed=speed, arguments=arguments))


_belt_rows()


@LEDGER.verified("belt.energy_ratio", "(61)", sp.Float(belt.energy_ratio()), numbers=DIGITS)
def _(claim):
    return agree(sp.Rational(5, 6), claim)


@LEDGER.verified(
    "belt.effective_friction",
    "below and above a Omega, at v = 1/10 and 1/2",
    *(sp.Float(belt.effective_friction(belt_scene(SLOW))(v)) for v in (0.1, 0.5)),
    numbers=DIGITS,
)
def _(*claim):
    mu_s, mu_m, v_m = (mp.mpf(sp.Rational(LAW[k]).p) / sp.Rational(LAW[k]).q for k in ("mu_s", "mu_m", "v_m"))

    def mean(v):
        def at(angle):
            w = v - mp.mpf(3) / 10 * mp.cos(angle)
            s = abs(w) / v_m
            return mp.sign(w) * (mu_s - 3 * (mu_s - mu_m) / 2 * (s - s**3 / 3))

        turn = [mp.acos(v / (mp.mpf(3) / 10))] if v < 0.3 else []
        return mp.quad(at, [0, *turn, mp.pi]) / mp.pi

    with mp.workdps(25):
        return [agree(sp.Float(mean(mp.mpf(n) / 10), 25), c) for n, c in zip((1, 5), claim, strict=True)]


# --- Tuned mass dampers -------------------------------------------------------------------------------------------
RATIOS = (sp.Rational(1, 20), sp.Rational(9, 2))
CRITERIA = {
    "hinf": absorber.least_peak,
    "h2": absorber.least_variance,
    "decay": absorber.fastest_decay,
    "self-excited": absorber.widest_stability,
}
FORMULAS = (absorber.fixed_points, *CRITERIA.values())


def formula_of_absorber(*claim, of, ratios):
    found = [e.subs(absorber.SYMBOLS.mu, r) for r in ratios for e in of(symbolic=True)]
    return [agree(f, c) for f, c in zip(found, claim, strict=True)]


for _of in FORMULAS:
    LEDGER.verified(
        f"absorber.{_of.__name__}",
        "tuning, damping and value for mu = 1/20 and 9/2",
        *(sp.Float(e) for r in RATIOS for e in _of(float(r))),
        numbers=DIGITS,
    )(partial(formula_of_absorber, of=_of, ratios=RATIOS))


def formula_of_design(*claim, of):
    at = {absorber.SYMBOLS.mu: RATIOS[0]}
    return [agree(e.subs(at), c) for e, c in zip(of(symbolic=True)[:2], claim, strict=True)]


for _criterion, _of in CRITERIA.items():
    LEDGER.verified(
        f"design.absorber, {_criterion}",
        "tuning and damping that the design returns for mu = 1/20",
        *(sp.Float(designed(float(RATIOS[0]), _criterion).values[k]) for k in ("tuning", "damping")),
        numbers=DIGITS,
    )(partial(formula_of_design, of=_of))


POINT = {"mass_ratio": 0.1, "tuning": 0.9, "damping": 0.1}
AT = {s: sp.Rational(n, 10) for s, n in zip(absorber.SYMBOLS[:3], (1, 9, 1), strict=True)}


@LEDGER.verified(
    "absorber.response, state_matrix",
    "response at g = 4/5, and the coefficients of the characteristic polynomial; mu = 1/10, f = 9/10, zeta = 1/10",
    sp.Float(absorber.response(**POINT, g=0.8)),
    *(sp.Float(float(c)) for c in sp.Matrix(absorber.state_matrix(0.1, 0.9, 0.1)).charpoly().all_coeffs()[1:]),
    numbers=DIGITS,
)
def _(response, *coefficients):
    from derivations.absorber import characteristic

    exact = absorber.response(symbolic=True).subs(AT).subs(absorber.SYMBOLS.g, sp.Rational(4, 5))
    found = [sp.sympify(c).subs(AT) for c in characteristic()]
    return [agree(exact, response), *(agree(f, c) for f, c in zip(found, coefficients, strict=True))]


# --- Decay of the contact damper ----------------------------------------------------------------------------------
# The time from the mean power of damper and friction alone: dt = dA/(zeta omega A + (2/pi)(mu_m r g/omega) F(A omega)),
# with F integrated as it is defined, int_0^{pi/2} sin p exp(-a sin p) dp.
DECAYS = (
    {"f_n": "10", "mu_m": "1/10"},
    {"f_n": "7/2", "mu_m": "1/5", "zeta": "1/50", "x0": "1/50"},
    {"f_n": "5", "mu_m": "3/20", "r": "2", "x0": "0", "v0": "3/5", "g": "981/100", "v_c": "1/2"},
)


@cache
def decay_time(case: int):
    given = {k: mp.mpf(sp.Rational(v).p) / sp.Rational(v).q for k, v in DECAYS[case].items()}
    with mp.workdps(20):
        omega = 2 * mp.pi * given["f_n"]
        g, r, v_c = (given.get(k, mp.mpf(d)) for k, d in (("g", "9.81"), ("r", 1), ("v_c", 1)))
        braking = 2 / mp.pi * given["mu_m"] * r * g / omega
        start = mp.sqrt(given.get("x0", mp.mpf("0.01")) ** 2 + (given.get("v0", 0) / omega) ** 2)

        def rate(amplitude):
            a = amplitude * omega / v_c
            mean = mp.quad(lambda p: mp.sin(p) * mp.exp(-a * mp.sin(p)), [0, mp.pi / 2])
            return given.get("zeta", mp.mpf(0)) * omega * amplitude + braking * mean

        return mp.quad(lambda amplitude: 1 / rate(amplitude), [0, start / 3, start])


@LEDGER.verified(
    "transient.averaged_decay_time",
    f"time until the averaged amplitude is zero, in {len(DECAYS)} cases",
    *(
        sp.Float(transient.averaged_decay_time(**{k: float(sp.Rational(v)) for k, v in case.items()}))
        for case in DECAYS
    ),
    numbers=f"{DIGITS}, by quadrature of the mean power",
)
def _(*claim):
    return [agree(sp.Float(decay_time(k), 20), c, digits=11) for k, c in enumerate(claim)]


@LEDGER.verified(
    "transient.mean_friction",
    "F(a) at a = 1/2, 3 and 40, and that of the law as printed at 1/2",
    *(sp.Float(transient.mean_friction(a)) for a in (0.5, 3.0, 40.0)),
    sp.Float(transient.mean_friction(0.5, literal=True)),
    numbers=DIGITS,
)
def _(*claim):
    with mp.workdps(25):

        def mean(a):
            edges = [0, *(mp.pi / 2 * k / 8 for k in range(1, 9))]
            return mp.quad(lambda p: mp.sin(p) * mp.exp(-a * mp.sin(p)), edges)

        found = [mean(mp.mpf(a)) for a in ("0.5", "3", "40")]
        found.append((mean(mp.mpf("0.5")) + mean(mp.mpf("-0.5"))) / 2)
        return [agree(sp.Float(f, 25), c) for f, c in zip(found, claim, strict=True)]


# --- Drawn slides, scale factors ----------------------------------------------------------------------------------
SLIDE = {sp.Symbol("mu1", real=True): -sp.Rational(3, 10), sp.Symbol("lambda", positive=True): sp.Integer(2)}


@LEDGER.verified(
    "drive.type_limit, single_section_error, steep_error",
    "at mu1 = -3/10, lambda = 2",
    sp.Float(drive.type_limit(-0.3)),
    sp.Float(drive.single_section_error(-0.3, 2.0)),
    sp.Float(drive.steep_error(-0.3, 2.0)),
    numbers=DIGITS,
)
def _(*claim):
    formulas = drive.type_limit, drive.single_section_error, drive.steep_error
    return [agree(f(symbolic=True).subs(SLIDE), c) for f, c in zip(formulas, claim, strict=True)]


@LEDGER.verified(
    "scaling.factors",
    "of a model 1:7 with D = 14/5, in the order of `Factors`",
    *(sp.Float(e) for e in scaling.factors(7.0, 2.8).to_dict().values()),
    numbers=DIGITS,
)
def _(*claim):
    at = dict(zip(scaling.SYMBOLS, (7, sp.Rational(14, 5)), strict=True))
    return [agree(e.subs(at), c) for e, c in zip(scaling.FACTORS.to_dict().values(), claim, strict=True)]
