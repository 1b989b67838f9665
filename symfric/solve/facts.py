"""What the routes look at when they decide whether they take a scene."""

from dataclasses import dataclass

from symfric.lower.automaton import Automaton, averaged_over, lower, vanishing
from symfric.model.outputs import Events, ScalarOfExpression, Trajectory
from symfric.model.scene import Scene


@dataclass(frozen=True)
class Facts:
    """Properties of a scene that decide its route and what can be left out.

    Attributes
    ----------
    contacts, kinks, states : int
        Number of contacts that can stick, of kinks in the forces and laws, of states.
    smooth : bool
        No contact can stick.
    autonomous, sampled : bool
        Time appears nowhere; an input is sampled.
    dropped : tuple of str
        Parameters that are exactly zero and are left out of the equations.
    averaged_over : tuple of str
        Parameters inside a law's mean over fast vibration, which is made for their present values.
    path, events, scalars : bool
        Whether a trajectory, the events, or scalar outputs are wanted.
    """

    contacts: int
    kinks: int
    states: int
    smooth: bool
    autonomous: bool
    sampled: bool
    dropped: tuple[str, ...]
    averaged_over: tuple[str, ...]
    path: bool
    events: bool
    scalars: bool


def facts_of(scene: Scene) -> Facts:
    """Look at a scene; lowers it, which takes some milliseconds."""
    automaton: Automaton = lower(scene)
    wanted = list(scene.outputs.values())
    return Facts(
        contacts=sum(automaton.sticks),
        kinks=automaton.n_switches,
        states=len(automaton.states),
        smooth=not any(automaton.sticks),
        autonomous=automaton.autonomous,
        sampled=bool(automaton.inputs),
        dropped=tuple(sorted(s.name for s in vanishing(scene))),
        averaged_over=tuple(sorted(s.name for s in averaged_over(scene))),
        path=any(isinstance(o, Trajectory) for o in wanted),
        events=any(isinstance(o, Events | Trajectory) for o in wanted),
        scalars=any(isinstance(o, ScalarOfExpression) for o in wanted),
    )
