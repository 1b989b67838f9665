"""HTML templates (Jinja2); values are escaped unless they are `Markup`."""

from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined, Template


@cache
def _environment() -> Environment:
    return Environment(
        loader=PackageLoader("symfric"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )


def template(name: str) -> Template:
    """Return a template of this folder."""
    return _environment().get_template(name)


def render(name: str, /, **values) -> str:
    """Render a template of this folder with the given values."""
    return template(name).render(values)
