"""Pages that are made from the package itself: names, keys of scene files, commands, gallery, figures and an animation.

A Sphinx extension. Pages are written before Sphinx looks for its sources; they are not kept in the repository.
"""

from pathlib import Path

from docs.pages import (
    commands,
    drawn,
    figures,
    gallery,
    keys,
    landing,
    ledger,
    mathml,
    messages,
    names,
    navigation,
    numbers,
)


def setup(app):
    """Register the makers of pages, and formulas as MathML."""
    mathml.setup(app)
    numbers.setup(app)
    drawn.setup(app)
    navigation.setup(app)
    app.connect("builder-inited", _make)
    app.connect("autodoc-process-docstring", names.explain_data)
    app.connect("autodoc-process-docstring", names.escape_bars)
    app.connect("html-page-context", _levels, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _levels(_app, _page, _template, context, _doctree) -> None:
    """Give the captions of the navigation, which are headings to screen readers, their level."""
    for name in ("furo_navigation_tree", "body"):
        if context.get(name):
            context[name] = context[name].replace('role="heading">', 'role="heading" aria-level="2">')


def _make(app) -> None:
    source = Path(app.srcdir)
    names.write(source / "reference")
    keys.write(source / "reference")
    commands.write(source / "reference")
    gallery.write(source / "gallery")
    figures.write(source / "figures")
    ledger.write(source / "ledger")
    landing.write(source / "made")
    messages.write(source / "reference")
