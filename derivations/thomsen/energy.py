"""Thomsen's mass on a moving belt: what quenching costs, (59)-(61), and the discussion."""

import sympy as sp

from derivations.ledger import Ledger
from derivations.thomsen.effective import ALPHA3, effective
from derivations.thomsen.model import ETA, INPUT, KINETIC, SINE, V_B0, Omega, beta, friction, in_regime, tau, v, v_m
from derivations.thomsen.pure_slip import stick_start
from derivations.thomsen.quenching import Q_STAR, quenching_intensity
from derivations.thomsen.separation import INTENSITY, T, general_motion, mean, orders, q, shaken, v_r
from symfric.theory import belt

PART = Ledger("thomsen", "5.3, 5.4: energy, discussion")


# --- 5.3 Energy considerations ----------------------------------------------------------------------------------------
@PART.corrected(
    "before (59)",
    "velocity at quasi-equilibrium, to order 1",
    right=-INTENSITY * sp.cos(T),
    printed=-INTENSITY * sp.sin(T),
    note="the derivative of (37); the sine is that of the position",
)
def _(claim):
    return orders(general_motion().diff(T) - shaken(claim), 0)


# With this velocity the integral E_inp of (4) is q^2 cos^2(T)/2 and a constant; (59) chooses the one that makes it the
# kinetic energy of the fast motion.
FAST_VELOCITY = -q * sp.cos(T)
SHARE = v_m**2 * (1 - 2 * beta / ETA)


@PART.verified(
    "(59)",
    "kinetic energy of the quenching motion, both forms",
    Q_STAR**2 * sp.cos(T) ** 2 / 2,
    SHARE * sp.cos(T) ** 2 / 3,
)
def _(*claims):
    star = {q: quenching_intensity()}
    energy = KINETIC.subs(v, FAST_VELOCITY).subs(star)
    power = shaken(INPUT).subs({v: FAST_VELOCITY, SINE: sp.sin(T)}).subs(star)
    stated = [in_regime(c) for c in claims]
    return [energy - c for c in stated] + [power - Omega * c.diff(T) for c in stated]


@PART.corrected(
    "(59) meaning",
    "work of the excitation over one of its periods, to the order of (59)",
    right=0,
    printed=Q_STAR**2 / 2,
    note="not the energy required: (59) flows to and fro. What quenching costs is the mean power that friction and "
    "damper take, belt.mean_power; the excitation supplies it by the part of x' of the next order",
)
def _(claim):
    return 2 * sp.pi / Omega * mean(shaken(INPUT).subs({v: FAST_VELOCITY, SINE: sp.sin(T)})) - claim


theta_0 = sp.Symbol("theta_0", real=True)
WAVE = sp.cos(tau + theta_0) ** 2


@PART.corrected(
    "(60)",
    "kinetic energy of the largest pure-slip vibration, both forms",
    right=(belt.largest_pure_slip_amplitude(symbolic=True) ** 2 * WAVE / 2, sp.Rational(2, 5) * SHARE * WAVE),
    printed=(belt.largest_pure_slip_amplitude(symbolic=True) ** 2 * WAVE / 2, sp.Rational(2, 3) * SHARE * WAVE),
    note="the factor of (21) and (22); with 2/3 the ratio (61) of the maxima would be 1/2, not the printed 5/6",
)
def _(*claims):
    energy = KINETIC.subs(v, stick_start() * sp.cos(tau + theta_0))
    return [energy - in_regime(c) for c in claims]


@PART.verified("(61)", "ratio of the two energies", belt.energy_ratio(symbolic=True), (Q_STAR / V_B0) ** 2)
def _(*claims):
    found = (quenching_intensity() / stick_start()) ** 2
    return [found - in_regime(c) for c in claims]


# --- 5.4 Discussion ---------------------------------------------------------------------------------------------------
@PART.verified(
    "5.4", "effective less true friction at v_b = a Omega: larger", sp.Rational(3, 2) * ALPHA3 * INTENSITY**3
)
def _(claim):
    return (effective(0) - friction(v_r, 1)).subs(v_r, q) - shaken(claim)
