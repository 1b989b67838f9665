"""Every numbered equation of the source has a row, and the numbers that the rows lean on are right themselves."""

import re
from pathlib import Path

import mpmath
import numpy as np
import pytest
import sympy as sp
from scipy import integrate

from derivations.sources import ledger_of

SOURCE = Path(__file__).parents[3] / "shared" / "sources" / "guida_dry_friction_instability.txt"


def test_every_numbered_equation_has_a_row():
    if not SOURCE.exists():
        pytest.skip(f"the source {SOURCE.name} is not beside the project")
    printed = {int(n) for n in re.findall(r"\((\d{1,2})\)", SOURCE.read_text())} - {0}
    assert printed == set(range(1, 28))
    rows = {int(found[1]) for e in ledger_of("guida").entries if (found := re.match(r"\((\d+)\)", e.equation))}
    assert rows == printed


def test_labels_are_unique():
    labels = [e.equation for e in ledger_of("guida").entries]
    assert len(set(labels)) == len(labels)


@pytest.mark.parametrize("mu", ["-.7", ".3"])
def test_the_logarithm_of_psi_is_that_of_the_formula(mu):
    from derivations.guida.error import psi
    from derivations.guida.orbits import log_psi

    formula = sp.log(psi(sp.Rational("1.3"), sp.Rational(mu)))
    with mpmath.workdps(30):
        assert abs(log_psi(mpmath.mpf("1.3"), mpmath.mpf(mu)) - formula.evalf(30)) < mpmath.mpf(10) ** -28


def test_errors_by_psi_join_at_critical_damping():
    from derivations.guida.orbits import error

    at = error("-1", "1", "2")[0]
    with mpmath.workdps(30):
        for near in ("-.99999999", "-1.00000001"):
            assert abs(error(near, near[1:], "2")[0] - at) < 1e-6


def test_the_cycle_of_figure_15():
    from derivations.guida.motion import sticks

    (_, before), (begin, end) = sticks(0.2, 0.3, 7.8)[-4:-2]
    assert end - before == pytest.approx(30.5259317470719, rel=1e-12)
    assert (end - begin) / (end - before) == pytest.approx(0.643933628935, rel=1e-11)


def test_sliding_and_sticking_agree_with_an_integration_of_the_equations():
    from derivations.guida.motion import ZETA, R, sticks

    found = sticks(0.2, 0.3, 7.8, horizon=100.0)

    def sliding(_t, y):
        return *y[2:], -0.4 * y[2] - y[0] - 1.0, -0.6 * y[3] - y[1] / ZETA**2 + R * 1.0

    def relative(_t, y):
        return y[2] - y[3] + 1

    relative.terminal, relative.direction = True, -1
    # the first stick: both slides move as one from (0, 0, -1, 0), which is linear
    A = np.zeros((4, 4))
    A[0, 2] = A[1, 3] = 1
    A[2] = A[3] = -np.array([R, 1 / ZETA**2, 0.4 * R, 0.6]) / (1 + R)
    release = found[0][1]
    exact = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    stuck = integrate.solve_ivp(lambda _t, y: A @ y, (0, release), [0.0, 0.0, -1.0, 0.0], **exact).y[:, -1]
    friction = (0.6 * stuck[3] + stuck[1] / ZETA**2 - 0.4 * stuck[2] - stuck[0]) / (1 + R)
    assert friction == pytest.approx(7.8, rel=1e-10)
    run = integrate.solve_ivp(sliding, (0, 100), stuck, events=relative, **exact)
    assert release + run.t_events[0][0] == pytest.approx(found[1][0], rel=1e-9)
