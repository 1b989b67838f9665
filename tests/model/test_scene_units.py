"""Units of scenes made in Python: checked, completed, converted from quantities, and shown wherever numbers are."""

import pickle
import zipfile

import numpy as np
import pint
import pytest
import sympy as sp

import symfric as sf
from symfric.scenefile.read import file_of

x, u = sp.symbols("x u", real=True)
m, k, c, W, v_b, mu_k, v_s = sp.symbols("m k c W v_b mu_k v_s", positive=True)
UREG = pint.UnitRegistry(cache_folder=None)
VALUES = {m: 0.6, k: 6e5, c: 24.0, W: 300.0, v_b: 0.1, mu_k: 0.38, v_s: 0.12}
UNITS = {"x": "m", "t": "s", "m": "kg"}


def pad(units=UNITS, values=VALUES, outputs=None, force=-k * x - c * u, normal=W, **more):
    law = sf.laws.stribeck(0.55, mu_k, v_s)
    contact = sf.Contact("disc", slip=u - v_b, normal=normal, law=law)
    used = {s: v for s, v in values.items() if s is not W or normal.has(W)}
    start = more.pop("initial", {x: 0.0, u: 0.0})
    wanted = outputs or {
        "x_max": sf.Max(x),
        "work": sf.Integral(sf.friction_force("disc") * u),
        "path": sf.Trajectory(),
    }
    system = sf.System([x], [u], [[m]], [force])
    return sf.Scene(system, [contact], used, start, more.pop("horizon", 0.05), wanted, units=units, **more)


def test_units_that_are_not_given_follow():
    scene = pad()
    assert dict(scene.units) == {
        "x": "m",
        "t": "s",
        "m": "kg",
        "u": "m/s",
        "k": "kg/s²" if scene.units["k"] == "kg/s²" else "N/m",
        "c": scene.units["c"],
        "W": "N",
        "v_b": "m/s",
        "mu_k": "",
        "v_s": "",
    }
    assert scene.units.of(k * x**2 / 2) == "J"
    assert scene.units.of(sf.friction_force("disc")) == "N"
    assert scene.units.of(x / v_b) == "s"


def test_a_scene_without_units_has_none():
    scene = pad(units={})
    assert not scene.units
    assert scene.units.of(x) == ""
    ax = sf.simulate(scene).plot()
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time t", "x")
    assert "units" not in sf.simulate(scene).to_xarray().x.attrs


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"units": {**UNITS, "k": "kg"}}, r"scene.force\[0\]|scene.mass"),
        ({"units": {**UNITS, "k": "kN/m"}}, r"scene.mass\[0\]\[0\]: m times the rate of u is in N and .* is in 1000 N"),
        ({"units": {**UNITS, "u": "mm/s"}}, "units.u: u is in mm/s and the rate of x is in m/s"),
        ({"units": {**UNITS, "v_b": "m"}}, "friction 'disc', slip: u is in m/s and -v_b is in m"),
        ({"units": {**UNITS, "W": "kN"}}, "friction 'disc': the load W is in kN and the force"),
        ({"units": {**UNITS, "mu_k": "N"}}, "friction 'disc', law: "),
        ({"units": {**UNITS, "kk": "N/m"}}, "units.kk: no such state or value; did you mean k"),
        ({"units": {**UNITS, k: 3}}, "units.k is '3'; give the unit as a text"),
        ({"units": {**UNITS, "k": "Nn/m"}}, "units.k: 'Nn/m' is not a unit"),
        ({"force": -k * x - c * u - 60 * u}, "60.*u is in .*; a number that multiplies has no unit"),
        ({"outputs": {"odd": sf.Max(x + u)}}, "outputs.odd: u is in m/s and x is in m"),
        ({"force": -k * x - c * x}, None),
        ({"initial": {x: W / k, u: W / k}}, "initial.u: the start W/k is in m and u is in m/s"),
        ({"units": ["m"]}, r"units is \['m'\]; give a mapping"),
    ],
)
def test_what_does_not_fit_is_refused_in_one_line(change, said):
    if said is None:
        assert pad(**change).units["c"] == pad(**change).units["k"]
        return
    with pytest.raises(sf.SceneError, match=said) as error:
        pad(**change)
    assert "\n" not in str(error.value)


def test_units_stay_with_a_scene_and_outputs_are_checked_when_they_change():
    scene = pad()
    for other in (
        scene.where({"v_b": 0.2}),
        scene.starting({"x": 1e-4}),
        scene.until(0.1),
        scene.wanting({"end": sf.End()}),
        scene.regularised(1e-3),
        pickle.loads(pickle.dumps(scene)),
    ):
        assert dict(other.units) == dict(scene.units)
    with pytest.raises(sf.SceneError, match="outputs.odd: u is in m/s and x is in m"):
        scene.wanting({"odd": sf.Max(x + u)})


def test_a_load_that_is_a_number_is_in_the_unit_of_the_forces():
    scene = pad(normal=sp.Integer(300))
    assert scene.units.of(sf.friction_force("disc")) == "N"


def test_quantities_bring_their_units_or_are_converted():
    measured = {
        m: 600 * UREG.gram,
        k: 600 * UREG.newton / UREG.millimeter,
        c: 24 * UREG.newton * UREG.second / UREG.meter,
        W: 0.3 * UREG.kilonewton,
        v_b: 100 * UREG.millimeter / UREG.second,
        mu_k: 0.38,
        v_s: 0.12,
    }
    si = {"x": "m", "t": "s", "m": "kg", "k": "N/m", "W": "N", "c": "N*s/m", "v_b": "m/s"}
    scene = pad(
        values=measured, units=si, horizon=50 * UREG.millisecond, initial={x: 0.0, u: 0 * UREG.meter / UREG.second}
    )
    plain = pad()
    assert list(scene.values.values()) == pytest.approx(list(plain.values.values()), rel=1e-15)
    assert scene.horizon == pytest.approx(0.05, rel=1e-15)
    assert sf.simulate(scene)["x_max"] == pytest.approx(sf.simulate(plain)["x_max"], rel=1e-12)
    own = pad(units={"x": "m", "t": "s"}, values={**VALUES, m: 0.6 * UREG.kilogram, k: 6e5 * UREG.newton / UREG.meter})
    assert (own.units["k"], own.units["W"]) == ("N/m", "N")
    with pytest.raises(sf.SceneError, match=r"scene.mass\[0\]\[0\]: m times the rate of u"):
        pad(units={"x": "m", "t": "s"}, values={**VALUES, m: 600 * UREG.gram, k: 6e5 * UREG.newton / UREG.meter})
    faster = own.where({"v_b": 200 * UREG.millimeter / UREG.second}).starting({"x": 1 * UREG.millimeter})
    assert faster.values[v_b] == pytest.approx(0.2, rel=1e-15)
    assert faster.initial[x] == pytest.approx(1e-3, rel=1e-15)
    assert own.until(2 * UREG.minute).horizon == 120.0
    for wrong in (lambda: own.where({"v_b": 3 * UREG.second}), lambda: pad(values={**VALUES, v_b: 3 * UREG.second})):
        with pytest.raises(sf.SceneError, match=r"v_b is in m/s, and its value 3 second is not|slip: u is in m/s"):
            wrong()
    with pytest.raises(sf.SceneError, match="v_b is 3.0 meter / second, and the scene does not say in which unit"):
        pad(units={}).where({"v_b": 3 * UREG.meter / UREG.second})


def test_units_stand_on_axes_and_in_tables():
    scene = pad(units={"x": "mm", "t": "ms", "m": "g"}, values={**VALUES})
    run = sf.simulate(scene.until(0.05))
    ax = run.plot()
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time t [ms]", "x [mm]")
    data = run.to_xarray()
    assert (data.t.attrs["units"], data.x.attrs["units"], data.u.attrs["units"]) == ("ms", "mm", "m/s")
    table = sf.sweep(scene.wanting({"x_max": sf.Max(x), "stop": sf.StopTime()}), {"v_b": [0.1, 0.2]})
    assert (table.x_max.attrs["units"], table.v_b.attrs["units"]) == ("mm", scene.units["v_b"])
    assert table.stop.attrs["units"] == "ms"
    assert "units" not in table.status.attrs
    assert np.all(table.status == 0)


def test_steps_and_units_for_other_programs_carry_them(tmp_path, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    run = sf.export.stepper(pad(), 1e-5).run(until=1e-4)
    assert (run.t.attrs["units"], run["disc.friction"].attrs["units"]) == ("s", "N")
    text = zipfile.ZipFile(sf.export.write_fmu(pad(), tmp_path / "pad.fmu", 1e-5).files[0]).read("modelDescription.xml")
    assert b'<Unit name="m/s" />' in text
    assert b'<Real unit="m/s" start="0.1" />' in text
    bare = sf.export.write_fmu(pad(units={}), tmp_path / "bare.fmu", 1e-5).files[0]
    assert b"Unit" not in zipfile.ZipFile(bare).read("modelDescription.xml").replace(b"InitialUnknowns", b"")


@pytest.mark.long(beside="test_units_stand_on_axes_and_in_tables")
def test_pictures_of_orbits_and_branches_show_units():
    scene = pad(outputs={"end": sf.End()})
    labels = lambda ax: (ax.get_xlabel(), ax.get_ylabel())  # noqa: E731
    orbit = sf.limit_cycle(scene)
    assert labels(orbit.plot()) == ("x [m]", "u [m/s]")
    assert "period [s]" in orbit._repr_html_()
    branch = sf.continue_cycle(scene, "v_b", (0.1, 0.105), start=orbit)
    assert labels(branch.plot()) == ("$v_{b}$ [m/s]", "half range of x [m]")
    assert branch.to_xarray().v_b.attrs["units"] == "m/s"


def test_the_page_of_a_study_has_them():
    scene = pad()
    assert dict(file_of(scene).units) == dict(scene.units)
    assert not file_of(pad(units={})).units
