"""HTML, through Jinja2: whatever enters a page is escaped there, unless it is `Markup` already."""

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
    """Return a page from a template of this folder and the values that it names."""
    return template(name).render(values)
