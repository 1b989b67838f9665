"""Formulas as MathML, which browsers draw themselves: the pages need no script and no network."""

import re

from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.util.logging import getLogger

LOG = getLogger(__name__)


def setup(app) -> None:
    """Register the writer of formulas in HTML."""
    app.add_html_math_renderer("docutils-mathml", (_inline, None), (_block, None))
    app.config.html_math_renderer = "docutils-mathml"


def _spelled_out(tex: str) -> str:
    r"""Return a formula in the LaTeX that docutils knows: without ``\Big``, and ``\tfrac32`` with its braces."""
    tex = re.sub(r"\\[bB]igg?[lr]?(?![a-zA-Z])", "", tex)
    return re.sub(r"\\[td]?frac\s*([A-Za-z0-9])\s*([A-Za-z0-9])", r"\\frac{\1}{\2}", tex)


def convertible(tex: str) -> bool:
    """Whether a formula in LaTeX can be shown.

    Parameters
    ----------
    tex : str
    """
    try:
        return bool(tex2mathml(_spelled_out(tex)))
    except Exception:
        return False


def _converted(node, inline: bool) -> str:
    try:
        return tex2mathml(_spelled_out(node.astext()), as_block=not inline)
    except Exception as error:
        LOG.warning("formula %r: %s", node.astext(), error, location=node)
        return node.astext()


def _inline(writer, node) -> None:
    from docutils.nodes import SkipNode

    writer.body.append(_converted(node, True))
    raise SkipNode


def _block(writer, node) -> None:
    from docutils.nodes import SkipNode

    writer.body.append('<div class="formula">' + _converted(node, False) + "</div>\n")
    raise SkipNode
