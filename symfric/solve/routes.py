"""Route selection: which solver takes a scene, and why the others do not."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from symfric.errors import NoRoute, SceneError
from symfric.locks import SYMBOLIC, alone
from symfric.long_calls import logged
from symfric.model.arguments import is_one_of
from symfric.model.results import Result
from symfric.model.scene import Scene, check_scene
from symfric.model.symbols import Key, nearest
from symfric.solve.exact.route import Exact
from symfric.solve.facts import Facts, facts_of, redundant, warn_of_redundance
from symfric.solve.integrators.route import Integrators
from symfric.solve.lowered import LoweredScene, directions_of
from symfric.solve.protocol import Answer, Program
from symfric.solve.run import Run
from symfric.solve.taylor.route import Taylor

RouteName: TypeAlias = Literal["exact", "taylor", "integrators"]
Settings = Exact | Taylor | Integrators
# in the order of preference
ROUTES: dict[str, Settings] = {
    "exact": Exact(general=Taylor()),
    "taylor": Taylor(),
    "integrators": Integrators(),
}


@dataclass(frozen=True)
class Explanation(Result):
    """The route selected for a scene, with reasons.

    Attributes
    ----------
    route : str
        The route that takes the scene.
    answers : dict of str to str
        The reason of each route for taking or declining the scene.
    skipped : tuple of str
        Parts of a simulation that the scene does not need and that are not computed.
    facts : Facts

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> print(str(sf.explain(belt)).splitlines()[0])
    route: taylor
    >>> sorted(sf.explain(belt).to_dict())
    ['answers', 'facts', 'route', 'skipped']
    """

    route: str
    answers: dict[str, str]
    skipped: tuple[str, ...]
    facts: Facts

    def __repr__(self) -> str:
        return f"Explanation(route {self.route}, {len(self.skipped)} things skipped)"

    def __str__(self) -> str:
        lines = [f"route: {self.route}"]
        lines += [f"  {name}: {answer}" for name, answer in self.answers.items()]
        return "\n".join([*lines, "skipped:", *(f"  {s}" for s in self.skipped)])


@alone(SYMBOLIC)
def explain(scene: Scene, sensitivities: Sequence[Key] = (), order: int = 1) -> Explanation:
    """Explain the route selection of a scene: the route, why the others decline, and what is not computed.

    Parameters
    ----------
    scene : Scene
    sensitivities : sequence of symbol or name
        As for `prepare`: derivatives may take another route.
    order : {1, 2}
        Of the derivatives.

    Returns
    -------
    Explanation

    Raises
    ------
    SceneError
        If the scene cannot be lowered at all.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> sf.explain(belt).route
    'taylor'
    """
    check_scene(scene)
    lowered = LoweredScene(scene, directions=directions_of(scene, sensitivities, order), order=order)
    chosen, answers = _selected(lowered)
    facts, words = facts_of(lowered), {}
    for name, answer in answers.items():
        slower = "not needed" if answer.preferred else f"slower here (route={name!r})"
        verdict = "takes it" if name == chosen else slower
        words[name] = f"{verdict if answer.takes else 'declines'}: {answer.words}"
    return Explanation(chosen, words, _skipped(facts, bool(lowered.directions)), facts)


def _selected(lowered: LoweredScene) -> tuple[str, dict[str, Answer]]:
    """Return the route that runs a scene, and the answers of all routes; `explain` and `prepare` both read it here."""
    answers = {name: route.answer(lowered) for name, route in ROUTES.items()}
    taking = [name for name, answer in answers.items() if answer.takes]
    if not taking:
        reasons = "; ".join(f"{name}: {answer.words}" for name, answer in answers.items())
        raise NoRoute(f"no route takes the scene: {reasons}")
    return next((name for name in taking if answers[name].preferred), taking[0]), answers


def _skipped(facts: Facts, derivatives: bool) -> tuple[str, ...]:
    notes = []
    if facts.autonomous:
        notes.append("time: the scene is autonomous, so time is no variable of the series")
    if facts.dropped:
        notes.append(f"terms with {', '.join(facts.dropped)}: exactly zero in this scene")
    if facts.averaged_over:
        notes.append(
            f"{', '.join(facts.averaged_over)} as variables: the mean of a law over fast vibration is made for their "
            "present values; a program that is run with others compiles once more, for all values, in half a minute"
        )
    if facts.smooth and not facts.kinks and not facts.remembering:
        notes.append("events: no contact can stick and no force has a kink")
    if not facts.path:
        notes.append("the trajectory: no output needs it, so memory does not grow with the horizon")
    if not facts.events:
        notes.append("the list of events: only their number is kept")
    if not facts.scalars:
        notes.append("extrema and integrals: no scalar output needs them")
    if not derivatives:
        notes.append("derivatives with respect to parameters: not asked for")
    return tuple(notes)


@logged
@alone(SYMBOLIC)
def prepare(
    scene: Scene,
    tolerance: float = 1e-9,
    route: RouteName | Settings | None = None,
    sensitivities: Sequence[Key] = (),
    order: int = 1,
) -> Program:
    """Compile a scene, to run it many times with other values.

    Parameters
    ----------
    scene : Scene
    tolerance : float
        Largest error of a step relative to the variation of each state, between 1e-16 and 0.1.
    route : str or settings, optional
        'exact', 'taylor', 'integrators', or the settings of one of them (`sf.Exact`, `sf.Taylor`, `sf.Integrators`);
        the cheapest one that takes the scene unless given.
    sensitivities : sequence of symbol or name
        Parameters to differentiate by, and states whose initial values to differentiate by; only by the route 'taylor'.
    order : {1, 2}
        Of the derivatives; second ones exist for motions without events.

    Returns
    -------
    Program
        With ``run(values={}, initial={})``; any number of threads may run one program at once.

    Raises
    ------
    SceneError
        If the scene or a setting is wrong.
    NoRoute
        If the given route declines the scene; the message says why.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> program = sf.prepare(belt.wanting({"end": sf.End()}))
    >>> (program.run({"v_b": 0.5}, {"x": 0.1})["end"].round(6)).round(6)
    array([ 0.249226, -0.000665])
    """
    check_scene(scene)
    scene.numbers()
    if names := redundant(scene):
        warn_of_redundance(names)
    lowered = LoweredScene(scene, directions=directions_of(scene, sensitivities, order), order=order)
    if route is None:
        return ROUTES[_selected(lowered)[0]].build(lowered, tolerance)
    settings = _settings(route)
    if refusal := settings.declines(lowered):
        raise NoRoute(f"the route {settings.name!r} declines: {refusal}; leave route=None for automatic selection")
    return settings.build(lowered, tolerance)


def _settings(route: str | Settings) -> Settings:
    if isinstance(route, Settings):
        return route
    if is_one_of(route, ROUTES):
        return ROUTES[route]
    raise SceneError(f"no route {route!r}{nearest(str(route), ROUTES)}")


@logged
def simulate(
    scene: Scene,
    tolerance: float = 1e-9,
    route: RouteName | Settings | None = None,
    sensitivities: Sequence[Key] = (),
    progress: Callable[[float], None] | None = None,
    order: int = 1,
) -> Run:
    """Simulate a scene: `prepare` and one run.

    Parameters
    ----------
    scene, tolerance, route
        See `prepare`.
    sensitivities : sequence of symbol or name
        Parameters, and states for their initial values, to differentiate by; see ``run.sensitivities``.
    progress : callable, optional
        Called repeatedly with the fraction of the horizon that is done.
    order : {1, 2}
        Order of the derivatives; with 2 also ``run.second_sensitivities``.

    Returns
    -------
    Run
        Check ``run.status``, or call ``run.checked()``.

    Examples
    --------
    >>> import symfric as sf
    >>> belt = sf.scenes.mass_on_belt(v_b=0.2)
    >>> run = sf.simulate(belt)
    >>> run
    Run(OK, taylor, t_final=100, 30 events)
    >>> run(50.0).round(6).round(6)
    array([0.419014, 0.196067])
    """
    return prepare(scene, tolerance, route, sensitivities, order).run(progress=progress)
