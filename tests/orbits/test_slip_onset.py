"""Where joints begin to slip along a branch, against the closed form of the structure whose joints all stick."""

import numpy as np
import pytest
import sympy as sp

import symfric as sf

st = sf.structures
W, P, N = sp.symbols("W P N", positive=True)


def joined(**values):
    """One mass with a Jenkins element, m = k = 1, c = 0.1, k_t = 0.5, mu = 0.3."""
    joint = st.RowContact("joint", [1.0], N, sf.laws.coulomb(0.3), stiffness=0.5)
    given = {W: 1.1, P: 0.1, N: 1.0} | {sp.Symbol(k, positive=True): v for k, v in values.items()}
    return st.Structure([[1.0]], [[1.0]], [[0.1]]).scene(
        [joint], {"q1": P * sp.cos(W * sf.TIME)}, values=given, horizon=200.0
    )


def flexibility(omega):
    return 1 / abs(1.5 - omega**2 + 0.1j * omega)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("start", [0.1, 0.5])
def test_the_force_at_which_a_joint_begins_to_slip(start):
    """The amplitude is N mu/k_t there, whether it is approached from the side that sticks or from the other."""
    branch = sf.continue_cycle(joined(P=start), "P", (0.05, 0.55))
    assert branch.ends == ("span", "span")
    (onset,) = branch.special
    assert (onset.kind, onset.contact) == ("slip-onset", "joint")
    assert onset.value == pytest.approx(0.6 / flexibility(1.1), rel=1e-10)
    assert onset.orbit.half_range[0] == pytest.approx(0.6, rel=1e-10)


def test_frequencies_between_which_a_joint_slips():
    branch = sf.frequency_response(joined(W=1.0), "W", (1.0, 1.5))
    # 0.01 |H|^2 = 0.36: a quadratic equation of W^2
    roots = np.sqrt(np.roots([1.0, 0.01 - 3.0, 2.25 - 0.01 / 0.36]))
    assert [s.kind for s in branch.special] == 2 * ["slip-onset"]
    assert [s.value for s in branch.special] == pytest.approx(sorted(roots), rel=1e-9)
    assert roots.min() < branch.peak.value < roots.max()
    ax = branch.plot()
    assert "slip-onset" in [text.get_text() for text in ax.get_legend().get_texts()]


def test_the_load_above_which_a_joint_sticks():
    branch = sf.continue_cycle(joined(N=0.6), "N", (0.3, 0.7))
    assert [s.value for s in branch.special] == pytest.approx([0.1 * flexibility(1.1) * 0.5 / 0.3], rel=1e-10)


@pytest.mark.long(beside="test_sharp_responses_of_laws_with_sliders")
def test_two_joints_of_a_chain():
    """The first slips where the linear structure says; the other, later, is told by its name."""
    chain = st.chain(4, damping=0.05)
    rows, stiff, limits = np.eye(4)[[0, 2]] - np.eye(4)[[1, 3]], [0.5, 1.0], [0.2, 0.5]
    joints = [
        st.RowContact(f"joint{k}", rows[k], limits[k], sf.laws.coulomb(1.0), stiffness=stiff[k]) for k in range(2)
    ]
    scene = chain.scene(joints, {"x1": P * sp.cos(0.5 * sf.TIME)}, values={P: 0.05}, horizon=300.0)
    dynamic = chain.K.toarray() - 0.25 * chain.M.toarray() + 0.5j * chain.C.toarray()
    q = np.linalg.solve(dynamic + rows.T @ np.diag(stiff) @ rows, np.eye(4)[0])
    forces = [limits[k] / (stiff[k] * abs(rows[k] @ q)) for k in range(2)]
    first = int(np.argmin(forces))
    branch = sf.continue_cycle(scene, "P", (0.05, 2.0 * max(forces)))
    assert [s.kind for s in branch.special] == 2 * ["slip-onset"]
    assert [s.contact for s in branch.special] == [f"joint{first}", f"joint{1 - first}"]
    assert branch.special[0].value == pytest.approx(forces[first], rel=1e-9)
    with pytest.raises(sf.SceneError, match="the onset of slip of 'joint0' has no curve|of 'joint1' has no curve"):
        sf.continue_special(branch.special[0], ("P", "P"), ((0.0, 1.0), (0.0, 1.0)))


def responses():
    """Elements (stiffness, limit) beside a unit mass, spring 1 and damping .004, and spans about the resonance."""
    one, stiff, two = ([0.3], [0.4], (0.8, 1.4)), ([3.0], [0.4], (1.5, 2.4)), ([0.3, 0.5], [0.4, 0.1], (0.8, 1.6))
    return [(*elements, force) for elements in (one, stiff, two) for force in (0.02, 0.05, 0.1)] + [(*stiff, 0.2)]


@pytest.mark.one_in(20)
@pytest.mark.parametrize("side", [0, 1])
@pytest.mark.parametrize(("stiffness", "limits", "span", "force"), responses())
def test_sharp_responses_of_laws_with_sliders(stiffness, limits, span, force, side):
    """From either end of a wide span: the first element slips where the amplitude of the structure that sticks says."""
    x, u = sp.symbols("x u", real=True)
    system = sf.System([x], [u], [[1]], [-x - 0.004 * u + force * sp.cos(W * sf.TIME)])
    joint = sf.Contact("joint", u, 1, sf.laws.maxwell_slip(stiffness, limits))
    scene = sf.Scene(system, [joint], {W: span[side]}, {x: 0, u: 0}, 400.0)
    branch = sf.frequency_response(scene, "W", span)
    square = 1 + sum(stiffness)  # of the frequency at which it would resonate
    most = min(limit / k for limit, k in zip(limits, stiffness, strict=True))
    # (square - W^2)^2 + (.004 W)^2 = (force/most)^2, a quadratic equation of W^2
    roots = np.sqrt(np.roots([1.0, 0.004**2 - 2 * square, square**2 - (force / most) ** 2]))
    assert [s.kind for s in branch.special] == 2 * ["slip-onset"]
    assert [s.value for s in branch.special] == pytest.approx(sorted(roots), rel=1e-9)


@pytest.mark.long(beside="test_sharp_responses_of_laws_with_sliders")
def test_the_point_is_the_same_over_spans_of_all_widths():
    x, u = sp.symbols("x u", real=True)
    system = sf.System([x], [u], [[1]], [-x - 0.004 * u + 0.05 * sp.cos(W * sf.TIME)])
    joint = sf.Contact("joint", u, 1, sf.laws.maxwell_slip([0.3], [0.4]))
    scene = sf.Scene(system, [joint], {W: 1.15}, {x: 0, u: 0}, 400.0)
    for span in ((1.14, 1.16), (1.12, 1.2), (0.5, 2.0)):
        last = sf.frequency_response(scene, "W", span).special[-1]
        assert last.value == pytest.approx(1.156379537, rel=1e-9), span
