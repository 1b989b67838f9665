"""Exceptions raised for wrong input and failed searches; a run that fails has a `Status` instead."""


class SceneError(ValueError):
    """Wrong input; the message names the item and the cure.

    Examples
    --------
    >>> import symfric as sf
    >>> try:
    ...     sf.scenes.mass_on_belt(v_b=0.2).where({"vb": 0.3})
    ... except sf.SceneError as error:
    ...     print(error)
    vb is no parameter of the scene; did you mean v_b?
    """


class NoRoute(RuntimeError):
    """No solver can take the scene; the message gives the reason of each one.

    Examples
    --------
    >>> import symfric as sf
    >>> try:
    ...     sf.simulate(sf.scenes.mass_on_belt(v_b=0.2), route="exact")
    ... except sf.NoRoute as error:
    ...     print(str(error)[:27])
    the route 'exact' declines:
    """


class NotFound(RuntimeError):
    """No solution was found in the range searched.

    Examples
    --------
    >>> import symfric as sf
    >>> try:
    ...     sf.hopf(sf.scenes.mass_on_belt(v_b=0.2), "v_b", bracket=(0.1, 0.2))
    ... except sf.NotFound as error:
    ...     print(str(error)[:31])
    steady sliding is unstable at b
    """


class RunFailed(RuntimeError):
    """A run ended before its horizon; the message gives the status and its advice.

    Examples
    --------
    >>> import symfric as sf
    >>> run = sf.simulate(sf.scenes.mass_on_belt(v_b=0.2), route=sf.Taylor(max_events=3))
    >>> run.status.name
    'EVENT_BUDGET'
    >>> try:
    ...     run.checked()
    ... except sf.RunFailed as error:
    ...     print(str(error)[:12])
    EVENT_BUDGET
    """
