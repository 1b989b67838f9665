"""The tree of all pages beside each of them, made once for the pages of a folder.

Furo makes it anew for every page, which takes most of the time of writing. In a folder the trees of two pages differ
only in what marks the page and those above it.
"""

import re
from functools import cache
from posixpath import basename, dirname

from sphinx.util.logging import getLogger

LOG = getLogger(__name__)
_TAG = re.compile(r'<(/?)(ul|li|a)\b(?: class="([^"]*)")?(?: href="([^"]*)")?>')
_BOX = 'class="toctree-checkbox"'


def setup(app) -> None:
    """Offer Furo the tree of the folder, and mark the page in what it makes of it."""
    of_folder = cache(lambda toctree, folder, wanted: toctree(f"{folder}/" if folder else "", **dict(wanted)))

    def offer(app, page: str, _template, context, _doctree) -> None:
        toctree = app.builder._get_local_toctree
        context["toctree"] = lambda **wanted: of_folder(toctree, dirname(page), tuple(sorted(wanted.items())))

    def mark(app, page: str, _template, context, _doctree) -> None:
        tree = context.get("furo_navigation_tree")
        if tree and page in app.env.found_docs and page != app.config.root_doc:
            marked = with_page(tree, basename(app.builder.get_target_uri(page)))
            if marked == tree:
                LOG.warning("the page is not in the tree of pages", location=page)
            context["furo_navigation_tree"] = marked

    app.connect("html-page-context", offer, priority=400)
    app.connect("html-page-context", mark, priority=800)


def with_page(tree: str, address: str) -> str:
    """Return a tree of pages in which one page, and those above it, are marked as current.

    Parameters
    ----------
    tree : str
        HTML as Furo makes it of a tree without a current page.
    address : str
        Of the page, as it stands in the tree.
    """
    above: list[re.Match[str]] = []
    for tag in _TAG.finditer(tree):
        closes, name, _, href = tag.groups()
        if name == "a":
            if href == address:
                return _marked(tree, tag, above)
        elif closes:
            above.pop()
        else:
            above.append(tag)
    return tree


def _marked(tree: str, link: re.Match[str], above: list[re.Match[str]]) -> str:
    """Return the tree with the link and what is above it marked, the innermost first so that places stay valid."""
    end = link.end()
    tree = f'{tree[: link.start()]}<a class="current {link[3]}" href="#">{tree[end:]}'
    innermost = True
    for tag in reversed(above):
        if tag[2] == "ul":
            new = '<ul class="current">'
        else:
            level, _, rest = tag[3].partition(" ")
            new = (
                f'<li class="{" ".join(filter(None, (level, "current", rest, "current-page" if innermost else "")))}">'
            )
            if rest:  # it has children, which are shown
                box = tree.index(_BOX, tag.end())
                tree = f'{tree[:box]}checked="" {tree[box:]}'
            innermost = False
        tree = tree[: tag.start()] + new + tree[tag.end() :]
    return tree
