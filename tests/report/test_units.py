"""Units of a scene file: what fits passes and is completed, what does not fit is one clear line."""

import math

import pytest
import sympy as sp

import symfric as sf
from symfric.scenefile import read_scene_text

SLIDE = """
[scene]
coordinates = "x"
velocities = "u"
mass = "m"
force = "-k*x - c*u"
horizon = 1.0
initial = { x = 0, u = 0 }
[values]
m = 400.0
k = 2.0e7
c = 6.0e3
W = 4000.0
v_f = 0.005
mu_k = 0.09
v_s = 0.012
[friction]
name = "way"
slip = "u - v_f"
normal = "W"
law = "stribeck"
mu_s = 0.14
mu_k = "mu_k"
v_s = "v_s"
[outputs]
largest = "max(x)"
work = 'integral(friction_force("way")*u)'
[units]
x = "m"
t = "s"
"""
ALL = 'u = "m/s"\nm = "kg"\nk = "N/m"\nc = "N s/m"\nW = "N"\nv_f = "m/s"\nv_s = "m/s"\nmu_k = "1"\n'


@pytest.mark.parametrize(
    ("given", "needed"),
    [
        ("", {"u": "m/s", "v_f": "m/s"}),
        ('m = "kg"\n', {"u": "m/s", "k": "kg/s²", "c": "kg/s", "W": "N", "v_s": "m/s", "mu_k": ""}),
        ('k = "N/m"\n', {"m": "kg", "c": "N s/m", "W": "N"}),
        (ALL, {"u": "m/s", "k": "N/m", "mu_k": ""}),
        ('k = "kN/m"\n', {"m": "1000 kg", "W": "1000 N"}),
    ],
)
def test_units_follow_from_the_equations(given, needed):
    units = read_scene_text(SLIDE + given).units
    for name, unit in needed.items():
        found = units[name]
        assert found == unit or sp.simplify(_number(found) / _number(unit)) == 1, (name, found)


def _number(unit):
    """A unit as an expression in symbols of base units."""
    m, kg, s = sp.symbols("m kg s", positive=True)
    text = unit.replace("²", "**2").replace(" ", "*")
    return sp.sympify(text or "1", {"m": m, "kg": kg, "s": s, "N": kg * m / s**2})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('k = "N/m"', 'k = "kg"'), r"scene.force\[0\]: -c\*u is in N and -k\*x is in kg m; mend"),
        (('k = "N/m"', 'k = "N/mm"'), r"scene.force\[0\]: -c\*u is in N and -k\*x is in 1000 N; mend"),
        (('u = "m/s"', 'u = "mm/s"'), "units.u: u is in mm/s and the rate of x is in m/s"),
        (('m = "kg"', 'm = "g"'), r"scene.mass\[0\]\[0\]: m times the rate of u is in 0.001 N"),
        (('W = "N"', 'W = "kN"'), "friction 'way': the load W is in kN and the force"),
        (('v_f = "m/s"', 'v_f = "m"'), "friction 'way', slip: u is in m/s and -v_f is in m"),
        (('v_s = "m/s"', 'v_s = "m"'), "friction 'way', law: -v/v_s is in 1/s and must be a plain number"),
        (('mu_k = "1"', 'mu_k = "N"'), "friction 'way', law: .* is in N"),
        (('"max(x)"', '"max(x + u)"'), "outputs.largest: u is in m/s and x is in m"),
        (('"max(x)"', '"max(sin(x))"'), "outputs.largest: x is in m and must be a plain number"),
        (("-k*x - c*u", "-k*x - 6000*u - c*u"), r"scene.force\[0\]"),
        (('x = "m"', 'x = "kgg"'), "units.x: 'kgg' is not a unit"),
        (('t = "s"', 't = "ms"'), "units.u: u is in m/s and the rate of x is in m/ms"),
    ],
)
def test_units_that_do_not_fit_are_one_line(change, message):
    whole = SLIDE + ALL
    assert change[0] in whole
    with pytest.raises(sf.SceneError, match=message) as error:
        read_scene_text(whole.replace(*change))
    assert "\n" not in str(error.value)


def test_units_of_expressions_and_outputs():
    file = read_scene_text(SLIDE + ALL)
    x, u = file.scene.system.q[0], file.scene.system.u[0]
    k, c = (file.scene.parameter(n) for n in "kc")
    units = file.units
    assert [units.of(e) for e in (x * k, u * c * u, u**2, x / u, sp.sqrt(k / file.scene.parameter("m")))] == [
        "N",
        "W",
        "m²/s²",
        "s",
        "1/s",
    ]
    assert units.of(sf.friction_force("way")) == "N"
    assert (units.rate, units.angular) == ("1/s", "rad/s")
    assert units.hertz == pytest.approx(1 / (2 * math.pi), rel=1e-15)
    assert units.of(x + u) == ""


def test_rotation_levers_and_other_systems_of_units():
    text = """
[scene]
coordinates = "phi"
velocities = "w"
mass = "J"
force = "-k*phi"
horizon = 10
initial = { phi = 0, w = 0 }
[values]
J = 2
k = 3
r = 0.1
N = 5
v = 0.02
[friction]
law = "coulomb"
mu_s = 0.3
slip = "r*w - v"
normal = "N"
[units]
phi = "rad"
t = "ms"
N = "kN"
r = "mm"
"""
    units = read_scene_text(text).units
    assert units["w"] in ("rad/ms", "1/ms")
    assert units["v"] == "mm/ms" or units["v"] == "m/s"
    assert units["k"] == "J" or units["k"] == "N m"  # kN mm
    assert units["J"].endswith("kg m²")
    assert units.hertz == pytest.approx(1e3 / (2 * math.pi), rel=1e-12)


def test_a_scene_without_units_has_none():
    file = read_scene_text(SLIDE[: SLIDE.index("[units]")])
    assert not file.units
    assert file.units.of(file.scene.system.q[0]) == file.units.rate == file.units.angular == ""
    assert math.isnan(file.units.hertz)
