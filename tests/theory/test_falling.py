"""Speeds at which friction falls, against closed forms and against the stability of steady sliding."""

import numpy as np
import pytest
from scipy.special import lambertw

import symfric as sf

L = sf.laws


@pytest.mark.parametrize(("f_d", "v_c", "b"), [(0.8, 0.3, 0.35), (0.5, 0.02, 0.1), (1.0, 2.0, 0.4), (0.3, 5.0, 0.06)])
def test_falling_section_of_both_stribeck_models(f_d, v_c, b):
    kappa = b * v_c / f_d
    exists = {"gauss": kappa**2 / 2 < np.exp(-1), "lorentz": kappa < 3 * np.sqrt(3) / 8}
    gauss = [v_c * np.sqrt(-lambertw(-(kappa**2) / 2, k).real / 2) for k in (0, -1)]
    quartic = np.roots([kappa, 0, 2 * kappa, -2, kappa])
    lorentz = np.sort(v_c * quartic[np.abs(quartic.imag) < 1e-9].real)
    for name, expected in (("gauss", gauss), ("lorentz", lorentz)):
        found = sf.theory.falling_speeds(getattr(L, name)(f_d, v_c, b=b))
        assert len(found) == exists[name]
        for pair in found:
            assert pair == pytest.approx(expected, rel=1e-9)


def test_without_viscous_part_they_fall_at_every_speed():
    for law in (L.gauss(0.8, 0.3), L.lorentz(0.8, 0.3), L.exponential(0.3), L.stribeck(0.4, 0.2, 0.1)):
        assert sf.theory.falling_speeds(law) == ((0.0, np.inf),)


def test_laws_with_branches_and_laws_that_do_not_fall():
    assert sf.theory.falling_speeds(L.coulomb(0.3)) == ()
    assert sf.theory.falling_speeds(L.square_root(0.8, 0.1)) == ()
    assert sf.theory.falling_speeds(L.cubic(0.4, 0.25, 0.5)) == ((0.0, pytest.approx(0.5, rel=1e-9)),)
    lines = L.piecewise_linear(0.4, [0, 0.1, 0.3, 0.5], [0.4, 0.3, 0.2, 0.25], last_slope=-0.1)
    assert sf.theory.falling_speeds(lines) == ((0.0, 0.3), (0.5, np.inf))
    assert sf.theory.falling_speeds(L.square_root(0.8, -0.9, b=0.9)) == ((0.0, pytest.approx(0.25, rel=1e-9)),)


def test_steady_sliding_is_unstable_there_and_only_there():
    law = L.gauss(0.4, 0.5, b=0.1)
    ((low, high),) = sf.theory.falling_speeds(law)
    for share in (0.99, 1.01):
        for edge, inside in ((low, share > 1), (high, share < 1)):
            scene = sf.scenes.mass_on_belt(law, v_b=share * edge, beta=0.0)
            assert sf.stability(scene).stable != inside


def test_a_law_with_symbols_is_refused():
    import sympy as sp

    with pytest.raises(sf.SceneError, match="no number for mu; use law.where"):
        sf.theory.falling_speeds(L.coulomb(sp.Symbol("mu")))
