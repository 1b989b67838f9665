"""Diagrams, curves of special points and maps of flutter that are interrupted keep their values until then, on request."""

import sys

import numpy as np
import pytest
import sympy as sp

import symfric as sf
from symfric.ensemble import bifurcation_diagram
from symfric.orbits.continuation import codim1, walk
from tests.test_progress import interrupt_after

BELT = sf.scenes.mass_on_belt(v_b=0.4)


@pytest.mark.parametrize(
    "options", [{"section": "u"}, {"section": "u", "jobs": 2}, {"section": "u", "carry": True}, {}]
)
def test_an_interrupted_diagram_keeps_its_values(options, monkeypatch):
    scene = BELT.until(60.0) if options else sf.scenes.mass_on_belt(v_b=0.2, a=0.01, Omega=10.0, horizon=60.0)
    values = np.linspace(0.2, 0.38, 6)
    monkeypatch.setattr(bifurcation_diagram, "_AT_ONCE", 2)
    whole = sf.bifurcation_diagram(scene, "v_b", values, **options)
    interrupt_after(monkeypatch, bifurcation_diagram, 3)
    with pytest.raises(KeyboardInterrupt):
        sf.bifurcation_diagram(scene, "v_b", values, **options)
    interrupt_after(monkeypatch, bifurcation_diagram, 3)
    with sf.keep_when_interrupted():
        part = sf.bifurcation_diagram(scene, "v_b", values, **options)
    assert part.status.tolist() == [0, 0, 0, 0, -3, -3]
    assert np.array_equal(part.states, whole.states[:, whole.case < 4])
    assert part.to_dict()["status"][-1] == "NOT_COMPUTED"
    part.plot()


@pytest.mark.parametrize("count", [2, 8])
def test_an_interrupted_curve_keeps_its_points(count, monkeypatch):
    special = sf.continue_cycle(BELT, "v_b", (0.38, 0.42)).special[0]
    ask = special, ("v_b", "beta"), ((0.38, 0.42), (0.04, 0.06)), 6
    whole = sf.continue_special(*ask)
    interrupt_after(monkeypatch, codim1, count)
    with sf.keep_when_interrupted():
        part = sf.continue_special(*ask)
    assert part.ends[1] == "interrupted"
    assert part.values.shape[1] == count + 2
    first = part.ends[0] == "interrupted"
    begin = 6 - count - 1 if first else 0
    assert np.array_equal(part.values, whole.values[:, begin : begin + count + 2])


def test_an_interrupted_map_of_flutter_and_an_onset_keep_what_they_found(monkeypatch):
    ask = {"mu": (0.5, 3.0), "count": 2}
    interrupt_after(monkeypatch, sys.modules[sf.structures.flutter_map.__module__], 2)
    with sf.keep_when_interrupted():
        part = sf.structures.flutter_map(lambda c: sf.structures.ziegler(damping=c), [1e-3, 1e-2, 1e-1], **ask)
    assert part.values.tolist() == [1e-3, 1e-2]
    assert part.mu.size == part.omega.size == len(part.found) == 2
    mu = sp.Symbol("mu", positive=True)
    s = sf.structures.Structure([[1, 0], [0, 1]], [[1.05, 0.2], [0.2, 0]], [[0.02, 0], [0, 0.02]], names=["x", "y"])
    load = sf.structures.RowLoad(1.0, {"y": 1.0}, push={"y": -1.0})
    law = sf.laws.custom(mu * (1 - 0.2 * sp.exp(-sf.SPEED)), mu)
    scene = s.scene([sf.structures.RowContact("belt", {"x": 1.0}, load, law, speed=1.0)], values={mu: 0.3})
    interrupt_after(monkeypatch, walk, 3)
    with sf.keep_when_interrupted():
        found = sf.structures.onset(scene, "mu", (0.1, 0.4), span=(0.2, 0.224))
    assert "interrupted" in found.branch.ends
    assert len(found.branch.orbits) > 2
