"""The status of a design: what its check and the designs beside it allow."""

import ast
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.design.comparison import Compared, Comparison
from symfric.design.verification import Neighbour, judged
from symfric.model.symbols import SPEED

PACKAGE = Path(sf.__file__).parent / "design"


@dataclass(frozen=True)
class Said:
    disagreements: tuple = ()

    @property
    def agrees(self):
        return not self.disagreements


WORSE, FORBIDDEN, BETTER = Neighbour("a", 2.0, -1.0), Neighbour("b", 0.5, 1e-12), Neighbour("c", 0.5, 0.0)


@pytest.mark.parametrize(
    ("claim", "check", "neighbours", "status", "words"),
    [
        ("optimal", Said(), [WORSE, FORBIDDEN], "optimal", ()),
        ("infimum", Said(), [WORSE], "infimum", ()),
        ("best found", Said(), [WORSE], "best found", ()),
        ("optimal", Said(), [WORSE, BETTER], "best found", ("c has the objective 0.5",)),
        ("optimal", Said(), [], "best found", ("no design beside it was computed",)),
        ("optimal", Said(("it vibrates",)), [WORSE], "unverified", ("it vibrates",)),
        ("infimum", Said(("it vibrates",)), [BETTER], "unverified", ("it vibrates",)),
    ],
)
def test_the_status_obeys_what_was_computed(claim, check, neighbours, status, words):
    assert judged(claim, check, neighbours, 1.0) == (status, words)


def test_a_maximum_is_beaten_by_more():
    assert judged("optimal", Said(), [Neighbour("more", 2.0, 0.0)], 1.0, sense=-1)[0] == "best found"
    assert judged("optimal", Said(), [Neighbour("less", 0.5, 0.0)], 1.0, sense=-1)[0] == "optimal"


def test_no_other_place_gives_a_design_its_status():
    for path in PACKAGE.glob("*.py"):
        calls = [n.func for n in ast.walk(ast.parse(path.read_text())) if isinstance(n, ast.Call)]
        made = [f for f in calls if isinstance(f, ast.Name) and f.id == "Design"]
        assert not made or path.name == "verification.py", path.name


def test_agreement_is_relative():
    assert not Compared("x", 1e-6, 1.1e-6, 1e-7).agrees
    assert Compared("x", 1e-6, 1e-6 * (1 + 1e-8), 1e-7).agrees
    assert Compared("u", 0.0, 1e-9, 1e-7, size=1.0).agrees
    assert not Compared("u", 0.0, 1e-9, 1e-7, size=1e-6).agrees
    assert not Compared("x", 1.0, np.nan, 1e-7).agrees
    rows = Comparison((Compared("x", 1.0, 1.0, 0.0), Compared("y", 1.0, 2.0, 0.1)))
    assert rows.disagreements == ("y: predicted 1, computed 2",)


def bumped(center, width, shape):
    """A law that falls slowly, with a bump: narrow arguments inside functions, of several shapes."""
    x = (SPEED - center) / width
    bumps = {
        "gauss": sp.exp(-(x**2)),
        "tanh": 1 - sp.tanh(x) ** 2,
        "quartic": 1 / (1 + x**4),
        "log": sp.exp(-((sp.log((SPEED + 1) / (1 + center)) / width) ** 2)),
        "sine": sp.exp(-((sp.sin(SPEED - center) / width) ** 2)),
        "erf": sp.erf(x + 1) - sp.erf(x - 1),
    }
    return sp.Rational(2, 5) - SPEED / 20 + bumps[shape] / 50


def steepest_fall(mu, center, width):
    slope = sp.lambdify(SPEED, -sp.diff(mu, SPEED), ["scipy", "numpy"])
    return float(np.max(slope(center + width * np.linspace(-4, 4, 200001))))


@pytest.mark.parametrize(
    ("shape", "width"),
    [
        ("gauss", 0.004),
        pytest.param("log", 0.002, marks=pytest.mark.long),
        pytest.param("gauss", 1e-4, marks=pytest.mark.long),
        pytest.param("tanh", 0.004, marks=pytest.mark.long),
        pytest.param("quartic", 0.001, marks=pytest.mark.long),
        pytest.param("sine", 0.004, marks=pytest.mark.long),
        pytest.param("erf", 0.002, marks=pytest.mark.long),
    ],
)
def test_the_damper_sees_narrow_features(shape, width):
    """2 beta = -mu' at its steepest: for one mass on a belt the stability of sliding decides."""
    mu = bumped(0.2713, width, shape)
    scene = sf.scenes.mass_on_belt(sf.laws.custom(mu, mu.subs(SPEED, 0)), v_b=0.3)
    found = sf.design.damper(scene, "beta", (0.0, 100.0), (0.05, 0.6))
    assert found.values["beta"] == pytest.approx(0.5 * steepest_fall(mu, 0.2713, width), rel=1e-6)
    assert found.status == "optimal", found.doubts


@pytest.mark.long(beside="test_the_damper_sees_narrow_features")
@pytest.mark.parametrize("width", [0.005, 0.001])
def test_the_quench_sees_narrow_features(width):
    """The mean of the slope over the fast motion, on a fine grid of speeds: negative with less, not with more."""
    mu = bumped(0.2713, width, "gauss")
    scene = sf.scenes.mass_on_belt(sf.laws.custom(mu, 0.4), v_b=0.3, a=0.0, Omega=20.0)
    found = sf.design.quench(scene, (0.05, 0.6), Omega=(20, 60), a=(0, 0.05))
    slope = sp.lambdify(SPEED, sp.diff(mu, SPEED), "numpy")
    theta = (np.arange(20000) + 0.5) * np.pi / 20000

    def damping(v, q):
        jump = 0.8 / np.pi / np.sqrt(q * q - v * v) if v < q else 0.0
        return 0.1 + np.mean(slope(np.abs(v - q * np.cos(theta)))) + jump

    q = found.objective
    near = [np.linspace(0.05, 0.6, 120), 0.2713 + width * np.linspace(-3, 3, 30)]
    near += [abs(0.2713 + side * q) + width * np.linspace(-3, 3, 60) for side in (-1, 1)]
    speeds = [v for v in np.concatenate(near) if 0.05 <= v <= 0.6]
    assert min(damping(v, 0.97 * q) for v in speeds) < 0
    assert min(damping(v, 1.001 * q) for v in speeds) >= 0
    assert found.status == "optimal", found.doubts
