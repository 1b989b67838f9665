"""One page that shows what was made again, with what the sources say and what was found."""

from collections.abc import Mapping
from html import escape
from importlib import resources

from symfric.report.entries import SOURCES, Entry, Finding, Made, title
from symfric.report.reproduction import NOT_MADE

VERDICTS = {True: "true", False: "not so", None: "open"}


def gallery(made: Mapping[str, tuple[Entry, Made, float]], versions: Mapping[str, str]) -> str:
    """Return the page.

    Parameters
    ----------
    made : mapping of name to (Entry, Made, seconds)
        The pictures lie beside the page, as ``name.png``.
    versions : mapping of str to str
    """
    style = resources.files("symfric.report").joinpath("style.css").read_text(encoding="utf-8")
    sources = [source for source in SOURCES if any(name.startswith(f"{source}-") for name in made)]
    body = [
        "<h1>Figures and tables of the sources, computed now</h1>",
        '<p class="lead">Beneath each: what the source says, and what was found.</p>',
        "<p>" + " · ".join(f'<a href="#{s}">{escape(SOURCES[s])}</a>' for s in sources) + "</p>",
    ]
    for source in sources:
        body.append(f'<h2 id="{source}">{escape(SOURCES[source])}</h2>')
        body += [_entry(n, *found) for n, found in made.items() if n.startswith(f"{source}-")]
        body += [
            f'<p class="note">Not made: {n}, {escape(w)}.</p>' for n, w in NOT_MADE.items() if n.startswith(source)
        ]
    used = ", ".join(f"{k} {v}" for k, v in versions.items() if v != "not installed")
    seconds = sum(time for _, _, time in made.values())
    body.append(f"<footer>Made in {seconds:.0f} s with {escape(used)}.</footer>")
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Reproduction</title><style>{style}</style></head>\n<body>\n" + "\n".join(body) + "\n</body></html>\n"
    )


def _entry(name: str, entry: Entry, made: Made, seconds: float) -> str:
    parts = [f'<h3 id="{name}">{escape(title(name))}</h3>', f"<p>{escape(entry.caption)}</p>"]
    if made.figure is not None:
        words = escape(f"{title(name)}. {entry.caption}")
        parts.append(f'<figure class="wide"><img src="{name}.png" alt="{words}" loading="lazy"></figure>')
    if made.text:
        parts.append(f'<div class="scroll"><pre>{escape(made.text)}</pre></div>')
    if made.findings:
        rows = "".join(_row(f) for f in made.findings)
        head = "<tr><th>the source</th><th></th><th>found</th></tr>"
        parts.append(f'<div class="scroll"><table><thead>{head}</thead><tbody>{rows}</tbody></table></div>')
    parts.append(f'<p class="note"><code>symfric reproduce {name}</code>, {seconds:.1f} s</p>')
    return "\n".join(parts)


def _row(finding: Finding) -> str:
    cells = (finding.claim, VERDICTS[finding.holds], finding.found)
    return "<tr>" + "".join(f"<td>{escape(c)}</td>" for c in cells) + "</tr>"
