"""One self-contained HTML page of a study: no script, no network, pictures and style inside."""

import math
from html import escape
from importlib import resources

import numpy as np

from symfric.report import designs, words
from symfric.report.mathml import equations_of_motion, friction_of_contact, inline, law_in_letters
from symfric.report.pictures import Picture, designs_shown, pictures
from symfric.report.study import DesignResult, StudyResult


def page(result: StudyResult) -> str:
    """Return the page."""
    style = resources.files("symfric.report").joinpath("style.css").read_text(encoding="utf-8")
    shown = pictures(result)
    title = escape(result.file.title or "A scene with dry friction")
    body = [
        f"<h1>{title}</h1>",
        "".join(f'<p class="lead">{escape(p)}</p>' for p in words.paragraphs(result.file.description)),
        _short(result),
        _table(result),
        _scene(result),
        _stability(result, shown["stability"]),
        _motion(result, shown["motion"]),
        _friction(result, shown["friction"]),
        _amplitude(result, shown["amplitude"]),
        _designs(result, designs_shown(result)),
        _skipped(result),
        _footer(result),
    ]
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{title}</title><style>{style}</style></head>\n<body>\n" + "\n".join(body) + "\n</body></html>\n"
    )


def number(value: float, digits: int = 6) -> str:
    """Return a number for reading."""
    if not math.isfinite(value):
        return "–"
    mantissa, _, exponent = f"{value:.{digits}g}".replace("-", "−").partition("e")
    power = str(int(exponent.replace("−", "-"))).replace("-", "−") if exponent else ""
    return f"{mantissa}·10<sup>{power}</sup>" if power else mantissa


def _heading(words_: str, name: str) -> str:
    return f'<h2 id="{name}">{escape(words_)}</h2>'


def _gallery(shown: list[Picture]) -> str:
    figures = "".join(
        f'<figure><img src="{p.uri}" alt="{escape(p.alt)}"><figcaption>{escape(p.caption)}</figcaption></figure>'
        for p in shown
    )
    return f'<div class="pair">{figures}</div>' if shown else ""


def _rows(head: list[str], rows: list[list[str]], numeric: set[int]) -> str:
    """Return a table; cells are HTML."""

    def line(cells: list[str], tag: str) -> str:
        made = (f"<{tag}{' class=n' if i in numeric else ''}>{c}</{tag}>" for i, c in enumerate(cells))
        return f"<tr>{''.join(made)}</tr>"

    body = "".join(line(r, "td") for r in rows)
    return f'<div class="scroll"><table><thead>{line(head, "th")}</thead><tbody>{body}</tbody></table></div>'


def _note(text: str) -> str:
    return f'<p class="note">{escape(text)}</p>'


def _short(result: StudyResult) -> str:
    items = "".join(f"<li>{escape(s)}</li>" for s in words.summary(result))
    return f'<div class="short"><strong>In short</strong><ul>{items}</ul></div>'


def _table(result: StudyResult) -> str:
    head = _heading("Predicted and computed", "comparison")
    if not result.rows:
        return head + _note(
            "No formula applies to this scene, so there is nothing to compare the computed numbers with."
        )
    rows = [
        [escape(r.quantity), number(r.predicted), number(r.computed), words.percent(r.difference), escape(r.formula)]
        for r in result.rows
    ]
    return head + _rows(["quantity", "predicted", "computed", "difference", "formula"], rows, {1, 2, 3})


def _scene(result: StudyResult) -> str:
    file, scene = result.file, result.file.scene
    parts = [_heading("The scene", "scene"), f"<p>{escape(words.scene_in_words(file))}</p>"]
    parts += equations_of_motion(scene)
    specs = {spec.contact: spec for spec in file.laws}
    for contact in scene.contacts:
        spec = specs.get(contact.name)
        name = f" ({spec.law} law)" if spec else ""
        parts.append(f"<h3>Contact {escape(contact.name)}{escape(name)}</h3>")
        parts += friction_of_contact(contact, law_in_letters(spec, contact))
        if spec:
            given = [f"{inline_name(k)} = {escape(words.shown(v))}" for k, v in spec.coefficients.items()]
            parts.append(f"<p>with {', '.join(given)}</p>")
    rows = [
        [inline(s), number(v), escape(file.units.get(s.name, "")), escape(words.role(s, file))]
        for s, v in scene.values.items()
    ]
    parts.append("<h3>Values</h3>" + _rows(["name", "value", "unit", ""], rows, {1}))
    return "\n".join(parts)


def inline_name(name: str) -> str:
    """Return a name as mathematics within a sentence."""
    import sympy as sp

    return inline(sp.Symbol(name))


def _matrix(name: str, matrix: np.ndarray) -> str:
    rows = "".join("<mtr>" + "".join(f"<mtd>{_mn(v)}</mtd>" for v in row) + "</mtr>" for row in np.atleast_2d(matrix))
    inside = f"<mi>{name}</mi><mo>=</mo><mrow><mo>(</mo><mtable>{rows}</mtable><mo>)</mo></mrow>"
    return f'<math display="block" aria-label="matrix {name}">{inside}</math>'


def _mn(value: float) -> str:
    text = f"{abs(value):.6g}"
    mantissa, _, exponent = text.partition("e")
    power = f"<mo>·</mo><msup><mn>10</mn><mn>{int(exponent)}</mn></msup>" if exponent else ""
    return f"{'<mo>−</mo>' if value < 0 else ''}<mn>{mantissa}</mn>{power}"


def _stability(result: StudyResult, shown: list[Picture]) -> str:
    parts = [_heading("Steady sliding and its stability", "stability")]
    if result.slow.value is not None and result.slow.value is not result.file.scene:
        parts.append(_note("The scene is shaken; what follows holds for the slow motion, with the effective friction."))
    at = result.equilibrium
    if at.value is None:
        parts.append(_note(f"No steady sliding: {at.note}"))
    else:
        position = ", ".join(f"{inline_name(n)} = {number(v)}" for n, v in zip(at.value.names, at.value.x, strict=True))
        slips = ", ".join(f"{escape(n)}: {number(w)}" for n, w in at.value.sliding.items())
        parts.append(f"<p>The forces balance at {position}. Sliding velocity: {slips or 'no contact'}.</p>")
    found = result.stability
    if found.value is None:
        parts.append("" if at.value is None else _note(f"Stability: {found.note}"))
    else:
        s = found.value
        parts.append(
            f"<p>Small motions about it obey <i>M q″ + B q′ + K q = 0</i>, friction included. Matrices: "
            f"<strong>{escape(s.definiteness)}</strong> ({escape(s.reason)}). Eigenvalues: steady sliding is "
            f"<strong>{'stable' if s.stable else 'not stable'}</strong>, growth rate {number(-s.margin)}.</p>"
        )
        parts += ['<div class="pair"><div>', *(_matrix(n, getattr(s, n)) for n in "MBK")]
        rows = [[number(v.real), number(v.imag)] for v in s.eigenvalues]
        parts += [_rows(["eigenvalue, real", "imaginary"], rows, {0, 1}), "</div>", _gallery(shown), "</div>"]
    parts.append(f"<p>{escape(words.onset(result))}</p>")
    return "\n".join(parts)


def _motion(result: StudyResult, shown: list[Picture]) -> str:
    parts = [_heading("The motion", "motion")]
    motion = result.motion.value
    if motion is None:
        return parts[0] + _note(f"Not computed: {result.motion.note}")
    parts += [f"<p>{escape(words.motion(result))}</p>", _gallery(shown)]
    if motion.outputs:
        rows = [[escape(k), number(v, 9)] for k, v in motion.outputs.items()]
        parts.append("<h3>What the file asks for</h3>" + _rows(["output", "value"], rows, {1}))
    return "\n".join(parts)


def _friction(result: StudyResult, shown: list[Picture]) -> str:
    head = _heading("Friction and effective friction", "friction")
    if not shown:
        return head + _note("The scene has no contacts.")
    parts = [head, _gallery(shown)]
    if not any(c.effective for c in result.friction):
        why = next(
            (c.note for c in result.friction if c.note), "the scene is not shaken, and the file designs no shaking"
        )
        parts.append(_note(f"No effective friction: {why}."))
    return "\n".join(parts)


def _amplitude(result: StudyResult, shown: list[Picture]) -> str:
    head = _heading(words.amplitude_heading(result), "amplitude")
    if result.sweep.value is None:
        return head + _note(f"Not computed: {result.sweep.note}.")
    parts = [head, *(f"<p>{escape(s)}</p>" for s in words.amplitude(result)), _gallery(shown)]
    return "\n".join(parts)


def _designs(result: StudyResult, shown: dict[str, list[Picture]]) -> str:
    if not result.designs:
        return _heading("Design", "design") + _note(
            "Nothing designed: the file has no [design.quench] or other design."
        )
    return "\n".join(_design(result, d, shown[d.plan.kind]) for d in result.designs)


def _design(result: StudyResult, made: DesignResult, shown: list[Picture]) -> str:
    head = _heading(designs.heading(made.plan), made.plan.kind) + f"<p>{escape(designs.asked(made.plan))}</p>"
    if made.design.value is None:
        return head + _note(f"Not designed: {made.design.note.rstrip('.')}.")
    lines = "".join(f"<p>{escape(s)}</p>" for s in designs.found(made.design.value))
    names = list(made.design.value.values)
    rows = [
        [inline_name(name) if name in names else escape(name), number(value), escape(unit)]
        for name, value, unit in designs.rows(made.plan, made.design.value, result.file)
    ]
    return "\n".join([head, lines, _rows(["name", "value", "unit"], rows, {1}), _gallery(shown)])


def _skipped(result: StudyResult) -> str:
    skipped = result.skipped()
    items = "".join(f"<li>{escape(k)}: {escape(v)}</li>" for k, v in skipped.items())
    head = _heading("How it was computed, and what was not", "how")
    route = result.explanation.note if result.explanation.value is None else str(result.explanation.value)
    lines = "".join(f"<p>{escape(line)}</p>" for line in route.splitlines() if line.strip())
    return head + lines + (f"<p>Without an answer:</p><ul>{items}</ul>" if skipped else "")


def _footer(result: StudyResult) -> str:
    used = ", ".join(f"{k} {v}" for k, v in result.versions.items() if v != "not installed")
    where = escape(result.file.path)
    return f"<footer>From <code>{where}</code> in {result.seconds:.1f} s with {escape(used)}.</footer>"
