"""What the derivations say of an approximation's error, measured on the full motion."""

import numpy as np
import pytest

import symfric as sf


@pytest.mark.one_in(2)
@pytest.mark.parametrize("Omega", [20, 30])
def test_the_spring_s_share_of_the_fast_velocity(Omega):
    scene = sf.scenes.mass_on_belt(v_b=0.3, a=0.01, Omega=Omega)
    branch = sf.continue_cycle(scene.where({"v_b": 0.45}).until(600.0), "v_b", (0.3, 0.5))
    exact = next(s.value for s in branch.special if s.kind == "neimark-sacker")
    plain = sf.theory.belt.unstable_speeds(scene)[1]
    q = 0.01 * Omega / (1 - Omega**-2)
    improved = np.sqrt(sf.theory.belt.onset_speed(scene) ** 2 - q**2 / 2)
    assert abs(improved - exact) < 2e-6
    assert abs(improved - exact) < 0.02 * abs(plain - exact)
