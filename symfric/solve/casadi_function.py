"""A scene as a CasADi function with exact first derivatives, for optimisers, root finders and larger graphs."""

import re
from collections.abc import Iterable, Sequence
from typing import Any

import casadi as ca
import numpy as np
import sympy as sp

from symfric.errors import SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.long_calls import logged
from symfric.model.arguments import is_one_of
from symfric.model.outputs import End
from symfric.model.scene import Scene, check_scene
from symfric.model.symbols import Key, name_of, nearest, shortened
from symfric.solve.routes import prepare
from symfric.solve.run import Run
from symfric.solve.status import Status


class SceneFunction(ca.Callback):
    """CasADi callback from parameters and initial values to outputs; made by `as_function`."""

    def __init__(self, scene: Scene, inputs: tuple[str, ...], outputs: tuple[str, ...], tolerance: float) -> None:
        ca.Callback.__init__(self)
        self.scene, self.inputs, self.outputs = scene, inputs, outputs
        self._states = tuple(s.name for s in scene.system.states)
        self._sizes = [scene.outputs[n].size(len(self._states)) or 0 for n in outputs]
        self._program = prepare(scene, tolerance, sensitivities=inputs)
        self._last: tuple[tuple[float, ...], Run] | None = None
        self._jacobians: list[ca.Callback] = []
        self.construct("scene", {})

    def get_n_in(self) -> int:
        """Return the number of inputs, each a scalar."""
        return len(self.inputs)

    def get_n_out(self) -> int:
        """Return the number of outputs."""
        return len(self.outputs)

    def get_name_in(self, i: int) -> str:
        """Return the name of an input in the characters that CasADi allows."""
        return _plain(self.inputs[i])

    def get_name_out(self, i: int) -> str:
        """Return the name of an output in the characters that CasADi allows."""
        return _plain(self.outputs[i])

    def get_sparsity_out(self, i: int) -> ca.Sparsity:
        """Return the shape of an output."""
        return ca.Sparsity.dense(self._sizes[i], 1)

    def at(self, point: tuple[float, ...]) -> Run:
        """Return the run at the values of the inputs; the last one is kept."""
        last = self._last  # local copy: another thread may replace it
        if last is None or last[0] != point:
            given = dict(zip(self.inputs, point, strict=True))
            initial = {n: v for n, v in given.items() if n in self._states}
            values = {n: v for n, v in given.items() if n not in self._states}
            self._last = last = point, self._program.run(values=values, initial=initial)
        return last[1]

    def eval(self, arg: Sequence[ca.DM]) -> list[ca.DM]:
        """Return the outputs; NaN if the run ended before its horizon."""
        run = self.at(tuple(float(a) for a in arg))
        complete = run.status in (Status.OK, Status.NO_DERIVATIVE)
        return [
            ca.DM(np.atleast_1d(run[name]) if complete else np.full(size, np.nan))
            for name, size in zip(self.outputs, self._sizes, strict=True)
        ]

    def blocks(self, point: tuple[float, ...]) -> list[ca.DM]:
        """Return the derivative of every output by every input, outputs first; NaN where there is none."""
        run, derivatives = self.at(point), []
        for name, size in zip(self.outputs, self._sizes, strict=True):
            for given in self.inputs:
                if run.status != Status.OK:
                    derivatives.append(ca.DM(np.full(size, np.nan)))
                elif isinstance(self.scene.outputs[name], End):
                    derivatives.append(ca.DM(run.sensitivities[given]))
                else:
                    derivatives.append(ca.DM(run.output_sensitivities[name][given]))
        return derivatives

    def has_jacobian(self) -> bool:
        """Whether exact derivatives are available: always."""
        return True

    def get_jacobian(self, name: Any, inames: Any, onames: Any, opts: Any) -> ca.Callback:
        """Return the Jacobian as a function of inputs and outputs."""
        self._jacobians.append(_Jacobian(self, name, inames, onames, self._sizes))
        return self._jacobians[-1]


class _Jacobian(ca.Callback):
    """All first derivatives of a `SceneFunction`; its own derivatives are differences."""

    def __init__(
        self, function: SceneFunction, name: str, inames: list[str], onames: list[str], sizes: Sequence[int]
    ) -> None:
        ca.Callback.__init__(self)
        self._function, self._inames, self._onames, self._sizes = function, inames, onames, sizes
        self.construct(name, {"enable_fd": True})

    def get_n_in(self) -> int:
        return len(self._inames)

    def get_n_out(self) -> int:
        return len(self._onames)

    def get_name_in(self, i: int) -> str:
        return self._inames[i]

    def get_name_out(self, i: int) -> str:
        return self._onames[i]

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        n = self._function.n_in()
        return ca.Sparsity.dense(1, 1) if i < n else ca.Sparsity(self._sizes[i - n], 1)

    def get_sparsity_out(self, i: int) -> ca.Sparsity:
        return ca.Sparsity.dense(self._sizes[i // self._function.n_in()], 1)

    def eval(self, arg: Sequence[ca.DM]) -> list[ca.DM]:
        return self._function.blocks(tuple(float(a) for a in arg[: self._function.n_in()]))


@logged
@alone(SYMBOLIC)
def as_function(scene: Scene, inputs: Sequence[Key], outputs: Sequence[str], tolerance: float = 1e-12) -> SceneFunction:
    """Wrap the motion of a scene as a ``casadi.Function``.

    Parameters
    ----------
    scene : Scene
    inputs : sequence of symbol or name
        Parameters, or states (for their initial values); each becomes a scalar input of that name.
    outputs : sequence of str
        Names of outputs of the scene: `End`, a vector (n_x,), or scalars.
    tolerance : float
        Tolerance of the run; tighter than elsewhere, since optimisers compare values.

    Returns
    -------
    casadi.Function
        With exact first derivatives, forward and reverse, in ``nlpsol``, ``rootfinder`` or a larger MX graph; second
        derivatives are differences of these. Values are NaN where the run ends early, derivatives where they do not
        exist. Keep a reference to it as long as a graph that contains it is used.

    Raises
    ------
    SceneError
        If a name is unknown, or an output is no number.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x = sp.Symbol("x", real=True)
    >>> scene = sf.scenes.mass_on_belt(v_b=0.2, horizon=20.0).wanting({"x_max": sf.Max(x)})
    >>> f = sf.as_function(scene, ["v_b"], ["x_max"])
    >>> round(float(f(0.2)), 6)
    0.566469
    >>> round(float(f.jacobian()(0.2, 0)), 6)
    0.834308
    """
    check_scene(scene)
    for what, given in (("inputs", inputs), ("outputs", outputs)):
        if isinstance(given, str | sp.Symbol) or not isinstance(given, Iterable):
            raise SceneError(f"{what} is {shortened(given)}; give a list of names, {what}=[{str(given)!r}]")
    names, outputs = tuple(name_of(n) for n in inputs), tuple(outputs)
    if not names or not outputs:
        raise SceneError("as_function needs at least one input and one output")
    for name in outputs:
        if not is_one_of(name, scene.outputs):
            raise SceneError(f"{shortened(name)} is no output of the scene{nearest(str(name), scene.outputs)}")
        if scene.outputs[name].size(len(scene.system.states)) is None:
            kind = type(scene.outputs[name]).__name__
            raise SceneError(f"output {name!r} is of type {kind}; only End and scalar outputs can be functions")
    kept = scene.wanting({name: scene.outputs[name] for name in outputs})
    missing = [n for n in names if n not in {s.name for s in (*kept.parameters, *kept.system.states)}]
    if missing:
        scene.parameter(missing[0])  # raises, if it is unknown
        raise SceneError(f"no equation and none of the chosen outputs depends on {missing[0]}")
    return SceneFunction(kept, names, tuple(outputs), tolerance)


def _plain(name: str) -> str:
    """Return a valid CasADi name: letters, digits and single underscores, beginning with a letter."""
    plain = re.sub(r"_+", "_", re.sub(r"\W", "_", name)).strip("_")
    return plain if plain[:1].isalpha() else f"i{plain}"
