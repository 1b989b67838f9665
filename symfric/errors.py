"""What can go wrong at the user's door; failures inside a run are a `Status`, not one of these."""


class SceneError(ValueError):
    """The input is wrong: names the thing and the cure."""


class NoRoute(RuntimeError):
    """No solver takes the scene; the message holds what each of them answered."""


class NotFound(RuntimeError):
    """The question has no answer in the range searched."""


class RunFailed(RuntimeError):
    """A run ended before its horizon; the message holds the status and its advice."""
