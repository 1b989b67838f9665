"""Motions of reduced structures against those of the full ones, within the estimates that the reduction says."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

st = sf.structures
SIZES = [60, pytest.param(200, marks=pytest.mark.long)]


def places(n):
    return [f"x{int(share * n)}" for share in (0.75, 0.85, 0.95)]


def compared(full, small, measure):
    """Return the relative difference of what is measured, and the estimate."""
    one, other = measure(full), measure(small)
    said = float(np.max(small.error.response) + np.max(small.error.frequency_error))
    return np.abs(np.array(other) / np.array(one) - 1), said


@pytest.mark.long(beside="test_amplitude_of_a_driven_chain")
@pytest.mark.parametrize("n", [36, 60, 200])
def test_period_and_amplitude_of_a_stick_slip_cycle(n):
    """A chain whose first mode alone is not damped enough, rubbed by a belt at three places."""
    chain = st.chain(n, ends="fixed-free")
    shape = chain.modes(1).shapes[:, 0]
    shape = shape / np.sqrt(shape @ (chain.M @ shape))
    own = chain.M @ shape
    C = 0.15 * chain.M.toarray() - 0.147 * np.outer(own, own)
    full = st.Structure(chain.M, chain.K, C, names=chain.names)
    law = sf.laws.stribeck(0.5, 0.3, 0.2)
    pads = [st.RowContact(name, {name: 1.0}, 0.2, law, speed=0.1) for name in places(n)]
    small = full.reduced(places(n), modes=8 if n == 60 else 24)
    begin = 3.5 * n / 60 * shape / shape[-1]

    def measure(s):
        start = begin if s is full else np.linalg.lstsq(s.basis, begin, rcond=None)[0]
        orbit = sf.limit_cycle(s.scene(pads, initial=start, horizon=4000.0 * n / 60))
        assert orbit.stable
        assert orbit.stick_fraction > 0.1
        assert orbit.multipliers.size == 2 * s.n
        return [orbit.period, *(orbit.half_range[orbit.names.index(name)] for name in places(n))]

    apart, said = compared(full, small, measure)
    assert np.all(apart <= said)
    assert said < 0.15


@pytest.mark.one_in(2)
@pytest.mark.parametrize("stiffness", [None, 0.5])
@pytest.mark.parametrize("n", SIZES)
def test_amplitude_of_a_driven_chain(n, stiffness):
    chain = st.chain(n, ends="fixed-free")
    full = st.Structure(chain.M, chain.K, 0.1 * chain.M, names=chain.names)
    law = sf.laws.coulomb(0.05)
    pads = [st.RowContact(name, {name: 1.0}, 1.0, law, stiffness=stiffness) for name in places(n)]
    drive, w = f"x{n}", 0.15 if n == 60 else 0.1
    small = full.reduced([*places(n), drive], modes=8 if n == 60 else 20)
    assert w < small.error.upto

    def measure(s):
        wanted = {"size": sf.HalfRange(sp.Symbol(drive, real=True)), "end": sf.End()}
        force = {drive: 0.2 * sp.cos(w * sf.TIME)}
        scene = s.scene(pads, force, horizon=40 * np.pi / w, outputs=wanted)
        run = sf.simulate(scene, 1e-8).checked()
        late = scene.starting(dict(zip(run.names, run["end"].tolist(), strict=True))).until(4 * np.pi / w)
        return [sf.simulate(late, 1e-8).checked()["size"]]

    apart, said = compared(full, small, measure)
    assert apart[0] <= said
    assert said < 0.15
