"""Modes and rates at the end of a run are those of the layout and of the equations, from any thread."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import symfric as sf
from symfric.lower.automaton import lower
from symfric.orbits.end_states import EndStates
from symfric_evidence.bench.larger import chain, slides

SCENES = {
    "belt": sf.scenes.mass_on_belt(v_b=0.2),
    "chain": chain(4),
    "slides": slides(),
    "impacts": sf.scenes.impact_oscillator(e=0.7, zeta=0.05, Omega=2.2),
    "pad": sf.scenes.brake_pad(v_b=0.2, k_t=-2.0),
}


def states(automaton, rng):
    """Return a state, time, parameters and a mode, each longer than what the equations take, as those of a run are."""
    field = automaton.field
    sizes = [field.nnz_in(i) for i in range(4)]
    m = rng.choice([-1.0, 0.0, 1.0], sizes[3])
    m[automaton.layout.sticking] = rng.choice([0.0, 1.0, 2.0, 3.0], len(automaton.layout.lines))
    return rng.normal(size=sizes[0] + 5), float(rng.uniform()), rng.uniform(0.5, 1.5, sizes[2] + 3), m


@pytest.mark.parametrize("name", SCENES)
def test_modes_and_rates_are_those_of_the_equations(name):
    automaton, rng = lower(SCENES[name], []), np.random.default_rng(3)
    ends, n_y, n_p = EndStates(automaton), automaton.field.nnz_in(0), automaton.field.nnz_in(2)
    for _ in range(50):
        y, t, p, m = states(automaton, rng)
        assert ends.modes(m) == tuple(automaton.layout.modes(m).tolist())
        exact = np.array(automaton.field(y[:n_y], t, p[:n_p], m)[0]).ravel()
        assert np.array_equal(ends.rate(y, t, p, m), exact, equal_nan=True)


def test_threads_do_not_share_memory():
    automaton = lower(SCENES["chain"], [])
    ends, n_y = EndStates(automaton), automaton.field.nnz_in(0)
    given = [states(automaton, np.random.default_rng(k)) for k in range(400)]
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda case: ends.rate(*case), given))
    n_p = automaton.field.nnz_in(2)
    for (y, t, p, m), rate in zip(given, found, strict=True):
        assert np.array_equal(rate, np.array(automaton.field(y[:n_y], t, p[:n_p], m)[0]).ravel())
