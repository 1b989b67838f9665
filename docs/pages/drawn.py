"""Check that a cell which draws shows a picture."""

import re

from docutils import nodes
from sphinx.util.logging import getLogger

LOG = getLogger(__name__)
_DRAWS = re.compile(r"\.plot\w*\(|\bplt\.show\(")


def setup(app) -> None:
    """Check every page once it is read."""
    app.connect("doctree-read", _check)


def _check(_app, doctree) -> None:
    for cell in doctree.findall(lambda n: isinstance(n, nodes.container) and "cell" in n["classes"]):
        if _DRAWS.search("".join(c.astext() for c in cell.findall(nodes.literal_block))) and not any(
            cell.findall(nodes.image)
        ):
            LOG.warning("a cell that draws shows no picture: %s", cell.astext().strip()[:80], location=doctree)
