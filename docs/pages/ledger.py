"""The ledger of the derivations, a page for each source, with its formulas typeset."""

import re
from pathlib import Path

import sympy as sp

from docs.files import put
from docs.pages.mathml import convertible

LEDGER = Path(__file__).parents[2] / "derivations" / "README.md"
_NAME = re.compile(r"[A-Za-z_]\w*")
_FUNCTIONS = "Abs acos acot asin asinh atan atan2 cos cosh cot exp log sign sin sinh sqrt tan tanh"
_FORMS = "Derivative Eq Ge Gt Heaviside Integral Le Limit Lt Matrix Max Min Ne Piecewise Rational Subs Sum oo pi"
_OF_SYMPY = {name: getattr(sp, name) for name in f"{_FUNCTIONS} {_FORMS}".split()}
_HIDDEN = """```{toctree}
:hidden:

"""


def write(folder: Path) -> None:
    """Write the page of every source and the page that counts them."""
    head, *parts = re.split(r"^## ", LEDGER.read_text(encoding="utf-8"), flags=re.MULTILINE)
    sources = []
    for part in parts:
        name, _, rest = part.partition("\n")
        words, *lines = rest.strip().split("\n\n")
        rows = [_cells(line) for line in lines[-1].splitlines()[2:]] if lines else []
        if len(rows[0] if rows else []) == 6 and "revised" not in name:
            sources.append(name)
            put(
                folder / f"{name}.md",
                f"# {name.replace('_', ' ').capitalize()}\n\n{words}\n\n" + "\n".join(map(_entry, rows)),
            )
        else:
            put(folder / "revised.md", f"# {name}\n\n{rest.strip()}\n")
    head = re.sub(r"\[(\w+)\]\(#\w+\)", r"[\1](\1.md)", head)
    put(folder / "index.md", head + "\n" + _HIDDEN + "\n".join([*sources, "revised"]) + "\n```\n")


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip().strip("|"))]


def _entry(cells: list[str]) -> str:
    """Return an equation as an entry of a definition list: what it says, and below the formula and its verdict."""
    equation, says, verdict, right, rest, residual = cells
    printed, note = _apart(rest)
    held = f"; {_escaped(residual)}" if residual not in ("", "0") else ""
    parts = [f"*{verdict}*{held}", _formulas(right)]
    parts += [f"as printed: {_formulas(printed)}"] if printed else []
    parts += [_escaped(note)] if note else []
    return f"**{_escaped(equation)}** {_escaped(says)}\n" + "".join(f": {p}\n" for p in parts if p)


def _apart(rest: str) -> tuple[str, str]:
    """Return the printed formula, if there is one, and the note."""
    if not rest.startswith("`"):
        return "", rest
    end = rest.index("`", 1) + 1
    return rest[:end], rest[end:].lstrip("; ")


def _formulas(code: str) -> str:
    """Return formulas, set apart by semicolons inside backticks, typeset; one that cannot be read stays code."""
    inside = code.strip("`").replace("\\|", "|")
    if not inside:
        return ""
    try:
        tex = [_tex(_read(formula)) for formula in inside.split("; ")]
    except Exception:
        return code
    return " ; ".join(f"${t}$" for t in tex) if all(map(convertible, tex)) else code


def _read(formula: str) -> sp.Basic:
    """Return a formula as SymPy prints it; its names are symbols and functions, none of them a constant of SymPy."""
    known = dict(_OF_SYMPY)
    for found in _NAME.finditer(formula):
        if found[0] not in known:
            known[found[0]] = (
                sp.Function(found[0]) if formula[found.end() : found.end() + 1] == "(" else sp.Symbol(found[0])
            )
    return sp.parse_expr(formula, local_dict=known)


def _tex(formula: sp.Basic) -> str:
    """Return a formula in LaTeX; names of several letters, such as `sine`, are upright, no products."""
    words = [s for s in formula.free_symbols if len(s.name) > 1 and sp.latex(s) == s.name]
    return sp.latex(formula, symbol_names={s: rf"\mathrm{{{s.name}}}" for s in words})


def _escaped(text: str) -> str:
    return re.sub(r"(?<!\\)([*_$`\[\]{}~])", r"\\\1", text)
