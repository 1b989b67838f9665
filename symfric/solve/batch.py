"""Results of many runs of one program, as arrays."""

from collections.abc import Callable, Generator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from symfric.errors import RunFailed, SceneError
from symfric.long_calls import tell, until_interrupted
from symfric.model.notebook import html_table
from symfric.model.results import BY_NAME, ArrayResult, Labelled, as_plain
from symfric.model.rows import CROSSINGS, INTEGRAL, RANGE
from symfric.model.scene import Scene
from symfric.solve.case_values import NOT_COMPUTED, CaseValues
from symfric.solve.observed import observables_of
from symfric.solve.run import Run
from symfric.solve.status import ADVICE, Status

if TYPE_CHECKING:
    pass


@dataclass(frozen=True, eq=False)
class Batch(ArrayResult):
    """Results of many cases of one scene; the last axis of every array is that of the cases.

    Attributes
    ----------
    outputs : dict of str to ndarray
        Scalar outputs (n,), final states (n_x, n), values at many times (n_t, n); NaN where a case failed.
    final : ndarray, shape (n_x, n)
        States at the end; NaN where a case failed.
    t_final : ndarray, shape (n,)
        When each case ended; NaN if its start, a formula of its values, is no finite number.
    status : ndarray of int, shape (n,)
        Codes of `Status`; -3 for a case that was not computed, see `symfric.keep_when_interrupted`.
    stats : dict of str to ndarray
        Counts (n,) of steps, events, kinks and grazes; a graze is an event or an instant that changes no mode.
    names : tuple of str
        Of the states.
    given : dict of str to ndarray
        Values and starts that vary, (n,).
    sensitivities : dict of str to ndarray
        Derivatives of the final states (n_x, n), by parameter or state; empty unless the program computes them.
    output_sensitivities : dict of str to dict
        Derivatives ``[output][name]`` of the outputs, with the cases last.

    Examples
    --------
    >>> import sympy as sp
    >>> import symfric as sf
    >>> x = sp.Symbol("x", real=True)
    >>> scene = sf.scenes.mass_on_belt(v_b=0.2, horizon=20.0).wanting({"x_max": sf.Max(x)})
    >>> batch = sf.prepare(scene).map({"v_b": [0.1, 0.2, 0.3]}).checked()
    >>> batch["x_max"].round(4).round(6)
    array([0.4832, 0.5665, 0.6501])
    >>> sorted(batch.to_dict())[:2]
    ['final', 'given']
    >>> list(batch.to_xarray().data_vars)[:1]
    ['x_max']
    """

    outputs: dict[str, np.ndarray]
    final: np.ndarray = field(metadata=BY_NAME)
    t_final: np.ndarray
    status: np.ndarray = field(metadata=as_plain(lambda codes, _: list(map(name_of_code, codes.tolist()))))
    stats: dict[str, np.ndarray]
    names: tuple[str, ...]
    given: dict[str, np.ndarray] = field(repr=False)
    sensitivities: dict[str, np.ndarray] = field(default_factory=dict, repr=False)
    output_sensitivities: dict[str, dict[str, np.ndarray]] = field(default_factory=dict, repr=False)
    _told = ("given", "outputs", "final", "t_final", "status", "stats")

    def _labelled(self) -> Labelled:
        known = [*([NOT_COMPUTED] if np.any(self.status == NOT_COMPUTED) else []), *map(int, Status)]
        codes = {"flag_values": np.array(known), "flag_meanings": " ".join(map(name_of_code, known))}
        data: dict[str, tuple] = {name: _over_cases(name, rows) for name, rows in self.outputs.items()}
        data |= {f"final_{name}": ("case", row) for name, row in zip(self.names, self.final, strict=True)}
        data |= {"t_final": ("case", self.t_final), "status": ("case", self.status, codes)}
        return data, {name: ("case", row) for name, row in self.given.items()}, {}

    @cached_property
    def ok(self) -> np.ndarray:
        """Which cases reached their horizon, shape (n,)."""
        return reached(self.status)

    def __len__(self) -> int:
        return self.status.size

    def __getitem__(self, name: str) -> np.ndarray:
        """Return an output by its name."""
        if name not in self.outputs:
            raise SceneError(f"{name!r} is no output; there are: {', '.join(self.outputs) or 'none'}")
        return self.outputs[name]

    def checked(self) -> "Batch":
        """Return self; raise `RunFailed` with the first failure and its advice if a case ended early.

        Returns
        -------
        Batch

        Raises
        ------
        RunFailed
            If a case failed; names the first one.
        """
        if not np.all(self.ok):
            k = int(np.flatnonzero(~self.ok)[0])
            code, lost = int(self.status[k]), int(np.count_nonzero(~self.ok))
            at = ", ".join(f"{name} = {row[k]:.9g}" for name, row in self.given.items())
            first, reason = f"the first is case {k}{f' ({at})' if at else ''}", _reason(code, self.t_final[k])
            raise RunFailed(f"{lost} of {len(self)} cases failed, {first}: {reason}")
        return self

    def _repr_html_(self) -> str:
        lost = {name_of_code(s): int(np.count_nonzero(self.status == s)) for s in np.unique(self.status).tolist()}
        return html_table("Batch", {"cases": len(self), "status": lost, "outputs": ", ".join(self.outputs) or "none"})

    def __repr__(self) -> str:
        lost = int(np.count_nonzero(~self.ok))
        names = ", ".join(self.outputs) or "none"
        return f"Batch({len(self)} cases{f', {lost} failed' if lost else ''}; outputs: {names})"


def name_of_code(code: int) -> str:
    """Return the name of a status, or NOT_COMPUTED."""
    return "NOT_COMPUTED" if code == NOT_COMPUTED else Status(code).name


def _reason(code: int, end: float) -> str:
    if code == NOT_COMPUTED:
        return "NOT_COMPUTED, since the map was interrupted before"
    return f"{Status(code).name} at t = {end:.9g}: {ADVICE[Status(code)]}"


def _over_cases(name: str, rows: np.ndarray) -> tuple[Any, np.ndarray]:
    return ("case", rows) if rows.ndim == 1 else ((f"{name}_index", "case"), rows)


def merged(cases: CaseValues, parts: list[tuple[np.ndarray, Batch]]) -> Batch:
    """Return one batch of all cases from batches of some of them, and their places."""

    def joined(of: Callable[[Batch], Mapping[str, np.ndarray]]) -> dict[str, np.ndarray]:
        names = dict.fromkeys(name for _, part in parts for name in of(part))
        return {name: _spread(cases.size, [(m, of(part).get(name)) for m, part in parts]) for name in names}

    rows = joined(lambda part: {"final": part.final, "t_final": part.t_final, "status": part.status})
    outputs, stats = joined(lambda part: part.outputs), joined(lambda part: part.stats)
    ends = joined(lambda part: part.sensitivities)
    names = parts[0][1].output_sensitivities
    of_outputs = {name: joined(partial(_of_output, name)) for name in names}
    of_cases = rows["final"], rows["t_final"], rows["status"], stats, parts[0][1].names, cases.given()
    return Batch(outputs, *of_cases, ends, of_outputs)


def _of_output(name: str, batch: Batch) -> dict[str, np.ndarray]:
    return batch.output_sensitivities[name]


def _spread(size: int, parts: list[tuple[np.ndarray, np.ndarray | None]]) -> np.ndarray:
    first = next(rows for _, rows in parts if rows is not None)
    out = np.zeros((*first.shape[:-1], size), first.dtype)
    for chosen, rows in parts:
        if rows is not None:
            out[..., chosen] = rows
    return out


def reached(status: np.ndarray) -> np.ndarray:
    """Whether each status means that the horizon was reached, with or without derivatives."""
    return (status == Status.OK) | (status == Status.NO_DERIVATIVE)


class _Rows(NamedTuple):
    """Observables of all runs, under the names that `symfric.solve.run.Raw` has for one run."""

    rows: Mapping[str, Any]
    rest: np.ndarray


class _Runs(NamedTuple):
    """All runs as outputs read them, under the names that a `Run` has for one."""

    final: np.ndarray
    raw: _Rows


def make_batch(
    scene: Scene,
    cases: CaseValues,
    final: np.ndarray,
    t_final: np.ndarray,
    status: np.ndarray,
    stats: dict[str, np.ndarray],
    rows: Mapping[str, Any],
    rest: np.ndarray,
) -> Batch:
    """Return the batch of some cases from what was found, with the cases last, of the rows of the outputs."""
    lost = ~reached(status)
    final = np.where(lost, np.nan, final)
    runs = _Runs(final, _Rows(rows, rest))
    outputs = {name: np.where(lost, np.nan, output.value(runs, name)) for name, output in scene.outputs.items()}
    names = tuple(s.name for s in scene.system.states)
    return Batch(outputs, final, t_final, status, stats, names, cases.given())


def batch_of_runs(
    scene: Scene, run: Callable[..., Run], cases: CaseValues, threads: int, progress: Callable[[float], None] | None
) -> Batch:
    """Return the batch of a program that makes its runs one by one.

    Parameters
    ----------
    scene : Scene
    run : callable
        Of values and starts by name.
    cases : CaseValues
    threads : int
    progress : callable or None
        Called with the fraction of the cases that are done.

    Raises
    ------
    SceneError
        If the scene refuses the numbers of a case; names the case.
    """

    def one(k: int) -> Run:
        try:
            return run(*cases.of(k))
        except SceneError as reason:
            raise SceneError(f"case {k}: {reason}") from None

    def all_runs() -> Generator[Run, None, None]:
        if threads == 1 or cases.size <= 1:
            yield from map(one, range(cases.size))
            return
        crew = ThreadPoolExecutor(threads)
        try:
            yield from crew.map(one, range(cases.size))
        finally:
            crew.shutdown(cancel_futures=True)

    runs: list[Run] = []
    with until_interrupted("map"), closing(all_runs()) as stream:
        for finished in stream:
            runs.append(finished)
            tell("", len(runs) / cases.size)
            if progress is not None:
                progress(len(runs) / cases.size)
        return _batch_of(scene, cases, runs)
    if not runs:
        raise KeyboardInterrupt
    computed = np.arange(cases.size) < len(runs)
    return _with_the_rest(cases, computed, _batch_of(scene, cases.some(computed), runs))


def _with_the_rest(cases: CaseValues, computed: np.ndarray, batch: Batch) -> Batch:
    """Return the batch of all cases from that of those that were computed."""
    whole, rest = merged(cases, [(computed, batch)]), ~computed
    rows = [*whole.outputs.values(), whole.final, whole.t_final, *whole.sensitivities.values()]
    rows += [row for by in whole.output_sensitivities.values() for row in by.values()]
    for row in rows:
        row[..., rest] = np.nan
    whole.status[rest] = NOT_COMPUTED
    return whole


def _batch_of(scene: Scene, cases: CaseValues, runs: list[Run]) -> Batch:
    final = np.array([r.final for r in runs]).reshape(-1, len(scene.system.states)).T
    t_final, rest = np.array([r.t_final for r in runs]), np.array([r.raw.rest for r in runs])
    status = np.array([int(r.status) for r in runs], dtype=np.int64)
    stats = {name: np.array([r.stats[name] for r in runs]) for name in (runs[0].stats if runs else ())}
    batch = make_batch(scene, cases, final, t_final, status, stats, _rows_of(scene, runs), rest)
    return replace(batch, **_derivatives_of(runs)) if runs and runs[0].raw.derivatives is not None else batch


def _derivatives_of(runs: list[Run]) -> dict[str, Any]:
    """Return the derivatives of runs with the cases last; NaN for those that failed."""
    lost = ~reached(np.array([int(r.status) for r in runs]))
    ends, outputs = [r.sensitivities for r in runs], [r.output_sensitivities for r in runs]

    def rows(values: list[Any]) -> np.ndarray:
        return np.where(lost, np.nan, np.moveaxis(np.array(values, dtype=float), 0, -1))

    of_outputs = {name: {d: rows([e[name][d] for e in outputs]) for d in outputs[0][name]} for name in outputs[0]}
    return {"sensitivities": {d: rows([e[d] for e in ends]) for d in ends[0]}, "output_sensitivities": of_outputs}


def _rows_of(scene: Scene, runs: list[Run]) -> dict[str, Any]:
    observables = observables_of(scene)
    rows: dict[str, Any] = {}
    for name, k in observables.row.items():
        row, values = observables.rows[k], [r.raw.rows[name] for r in runs]
        if row.kind in (RANGE, CROSSINGS):
            rows[name] = tuple(np.array(values).reshape(-1, 2 if row.kind == RANGE else 3).T)
        else:
            rows[name] = np.array(values).T if row.kind == INTEGRAL else np.array(values).reshape(-1, len(row.times)).T
    return rows
