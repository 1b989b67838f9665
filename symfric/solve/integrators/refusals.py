"""What the integrators cannot do."""

from collections.abc import Mapping

from symfric.errors import NoRoute
from symfric.lower.automaton import Automaton
from symfric.model.outputs import RMS, Integral, Mean, Output, OutputOfExpression, Period
from symfric.model.scene import Scene
from symfric.model.steps import jumps_in_time
from symfric.solve.integrators.mode_functions import ONE_STEP


def has_events(automaton: Automaton) -> bool:
    """Whether a contact can stick, or is behind a spring."""
    return any(automaton.sticks) or bool(automaton.layout.others)


def refuse_crossings(outputs: Mapping[str, Output]) -> None:
    """Raise `NoRoute` if a period is wanted, whose crossings only the event loop locates."""
    for name, output in outputs.items():
        if isinstance(output, Period):
            raise NoRoute(f"the route 'integrators' declines: output {name!r} is a period, for the route 'taylor'")


def kinks_matter(scene: Scene) -> bool:
    """Whether outputs besides the end and integrals exist, in a scene whose kinks are not those of laws with memory."""
    watched = any(
        o.keeps_path or (isinstance(o, OutputOfExpression) and not isinstance(o, Integral | Mean | RMS))
        for o in scene.outputs.values()
    )
    return watched and not any(c.law.memory for c in scene.contacts)


def remembering(scene: Scene) -> bool:
    """Whether a contact along a line has a law with memory."""
    return any(c.law.memory is not None and c.along_line for c in scene.contacts)


def declines(automaton: Automaton, plugin: str | None, scene: Scene, derivatives: bool = False) -> str:
    """Return the reason why a plugin cannot run a scene, or not with derivatives; empty if it can."""
    jumps = _jumping(automaton, plugin, scene)
    if jumps:
        return jumps
    if plugin == "cvodes" and remembering(scene) and not derivatives:
        if automaton.at_edges and has_events(automaton):
            return "a profile jumps, and a contact can stick"
        return ""
    springs = [c for c in automaton.layout.others if not c.clocks]
    if springs:
        return f"contact {springs[0].name!r} is behind a spring"
    if plugin in ONE_STEP:
        return ""
    if any(automaton.sticks):
        other = "" if derivatives else ", or the plugin 'erk' or 'rosenbrock'"
        return f"{plugin} has no events that work, and a contact can stick; use scene.regularised(v_s){other}"
    if kinks_matter(scene) and automaton.layout.switches:
        other = "" if derivatives else ", or use the plugin 'erk' or 'rosenbrock'"
        return f"{plugin} steps over kinks, so only the end and integrals are right; want those alone{other}"
    return ""


def _jumping(automaton: Automaton, plugin: str | None, scene: Scene) -> str:
    """Return why the route declines what only the event loop takes; empty if there is nothing."""
    if scene.clocks and plugin not in ONE_STEP:
        return f"held variables and resets restart the motion at every instant, which {plugin} does not"
    if any(part.crossing is not None for part in scene.clocks):
        return "a held variable or reset waits for a crossing, which only the event loop takes"
    for c in scene.contacts_that_open:
        return f"contact {c.name!r} opens and strikes, which only the event loop takes"
    if automaton.planes:
        return "a contact slides in the plane, which only the event loop takes"
    if automaton.steps and plugin not in ONE_STEP and any(map(jumps_in_time, scene.system.expressions)):
        return f"a force steps in time, over which {plugin} steps without an event"
    held = {s for s, signal in scene.inputs.items() if signal.hold}
    for c in scene.contacts:
        if any(jumps_in_time(e) or held & e.free_symbols for e in (c.slip, c.normal, *c.law.expressions)):
            return f"slip, load or law of contact {c.name!r} steps in time, which only the event loop takes"
    return ""
