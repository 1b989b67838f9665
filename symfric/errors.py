"""Exceptions raised for wrong input and failed searches; a run that fails has a `Status` instead."""


class SceneError(ValueError):
    """Wrong input; the message names the item and the cure."""


class NoRoute(RuntimeError):
    """No solver can take the scene; the message gives the reason of each one."""


class NotFound(RuntimeError):
    """No solution was found in the range searched."""


class RunFailed(RuntimeError):
    """A run ended before its horizon; the message gives the status and its advice."""
