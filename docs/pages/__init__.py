"""Pages that are made from the package itself: names, keys of scene files, commands, gallery and figures.

A Sphinx extension. Pages are written before Sphinx looks for its sources; they are not kept in the repository.
"""

from pathlib import Path

from docs.pages import commands, figures, gallery, keys, ledger, mathml, messages, names, numbers


def setup(app):
    """Register the makers of pages, and formulas as MathML."""
    mathml.setup(app)
    numbers.setup(app)
    app.connect("builder-inited", _make)
    app.connect("autodoc-process-docstring", names.explain_data)
    app.connect("autodoc-process-docstring", names.escape_bars)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _make(app) -> None:
    source = Path(app.srcdir)
    names.write(source / "reference")
    keys.write(source / "reference")
    commands.write(source / "reference")
    gallery.write(source / "gallery")
    figures.write(source / "figures")
    ledger.write(source / "ledger")
    messages.write(source / "reference")
