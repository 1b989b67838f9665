"""The small sweep, run once."""

import pytest
from small_sweep import small_grid, small_scene

import symfric as sf


@pytest.fixture(scope="session")
def small():
    return sf.sweep(small_scene(), small_grid())
