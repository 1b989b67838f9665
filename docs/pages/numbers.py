"""Check the prose of executed pages: a number that no cell prints, and no code has, is a warning.

A claim that no visible cell prints gets a hidden cell that asserts it.
"""

import re
from pathlib import Path

from docutils import nodes
from sphinx.util.logging import getLogger

from docs.founded import unfounded, values

LOG = getLogger(__name__)
_CELL = re.compile(r"```\{code-cell\}[^\n]*\n(.*?)```", re.DOTALL)


def setup(app) -> None:
    """Check every page once it is read."""
    app.connect("doctree-read", _check)


def _check(app, doctree) -> None:
    source = Path(app.env.doc2path(app.env.docname))
    cells = _CELL.findall(source.read_text(encoding="utf-8")) if source.suffix == ".md" else []
    if not cells:
        return
    outputs = [n.astext() for n in doctree.findall(nodes.container) if "cell_output" in n["classes"]]
    known = {v for part in (*outputs, *cells) for v in values(part)}
    for said in unfounded(_prose(doctree), known):
        LOG.warning("the number %s is printed by no cell of this page, and no code has it", said, location=doctree)


def _prose(doctree) -> list[str]:
    """Return the texts of paragraphs, headings and tables, without code, formulas and outputs."""
    found = []
    for node in doctree.findall(lambda n: isinstance(n, nodes.paragraph | nodes.title) and not _in_a_cell(n)):
        parts = (t.astext() for t in node.findall(nodes.Text) if not isinstance(t.parent, nodes.literal | nodes.math))
        found.append("".join(parts))
    return found


def _in_a_cell(node) -> bool:
    while node is not None:
        if "cell" in getattr(node, "attributes", {}).get("classes", ()):
            return True
        node = node.parent
    return False
