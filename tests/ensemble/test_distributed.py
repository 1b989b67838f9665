"""A sweep over worker processes of dask, killed on the way and continued, has the bits of `map`."""

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import symfric as sf
from symfric.ensemble.store import records_in
from tests.ensemble.million_belts import belts, grid

HERE = Path(__file__)


def run(store, number, until):
    command = [sys.executable, str(HERE.with_name("million_belts.py")), str(store), str(number), str(until)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    begin = time.perf_counter()
    done = subprocess.run(command, env=environment, timeout=900, capture_output=True, text=True)
    return done.returncode, time.perf_counter() - begin


@pytest.mark.parametrize("number", [20_000, pytest.param(1_000_000, marks=pytest.mark.long)])
def test_killed_and_continued_it_has_the_bits_of_map(tmp_path, number):
    pytest.importorskip("distributed", reason="the extra `distributed` is not installed")
    store = tmp_path / "store"
    status, _ = run(store, number, 0.3)
    assert status == 9
    kept = records_in(store)
    assert 0.25 * number < kept < number
    status, seconds = run(store, number, 2.0)
    assert status == 0
    found = sf.sweep(belts(), grid(number), store=store)  # all there: nothing is computed
    values = [a.ravel() for a in np.meshgrid(*grid(number).values(), indexing="ij")]
    pick = np.random.default_rng(0).choice(number, min(number, 40_000), replace=False)
    program = sf.prepare(belts())
    changes = {n: v[pick] for n, v in zip(grid(number), values, strict=True)}
    program.map({n: v[:50] for n, v in changes.items()})
    begin = time.perf_counter()
    batch = program.map(changes)
    here = (time.perf_counter() - begin) / pick.size
    assert np.array_equal(found["half"].values.ravel()[pick], batch["half"])
    print(f"{1e6 * seconds / (number - kept):.1f} us a case over two workers, {1e6 * here:.1f} by map on one thread")
