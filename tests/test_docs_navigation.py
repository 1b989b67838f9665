"""The tree of pages that is made once for a folder, against the one that Furo makes for every page."""

import pytest

furo = pytest.importorskip("furo.navigation")
navigation = pytest.importorskip("docs.pages.navigation")

LEAVES = {"install.html": (), "index.html": ("one.html", "two.html"), "../api/index.html": ("../api/names.html",)}


def tree(current=""):
    """Return two lists of pages as Sphinx makes them, with or without a current page."""
    lists = []
    for pages in (("install.html",), ("index.html", "../api/index.html")):
        inside = [entry(page, current, 1) for page in pages]
        here = any("current" in e for e in inside)
        marked = ' class="current"' if here else ""
        lists.append(f"<ul{marked}>\n{''.join(inside)}</ul>")
    return '<p class="caption" role="heading"><span class="caption-text">Start</span></p>\n'.join(["", *lists])


def entry(page, current, level):
    below = [entry(leaf, current, level + 1) for leaf in LEAVES.get(page, ())]
    on_way = page == current or any("current" in e for e in below)
    kind, href = ("current ", "#") if page == current else ("", page)
    link = f'<a class="{kind}reference internal" href="{href}">'
    above = ' class="current"' if any("current" in e for e in below) else ""
    inside = f"<ul{above}>\n{''.join(below)}</ul>\n" if below else ""
    return f'<li class="toctree-l{level}{" current" if on_way else ""}">{link}Page</a>{inside}</li>\n'


@pytest.mark.parametrize("page", ["install.html", "index.html", "one.html", "two.html", "../api/names.html"])
def test_a_page_is_marked_as_furo_does(page):
    assert navigation.with_page(furo.get_navigation_tree(tree()), page) == furo.get_navigation_tree(tree(page))


def test_a_page_outside_of_the_tree_changes_nothing():
    whole = furo.get_navigation_tree(tree())
    assert navigation.with_page(whole, "elsewhere.html") == whole
