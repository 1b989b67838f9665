"""The reproduced figures and tables of the sources, with what each source claims and what was found."""

from collections import Counter
from dataclasses import asdict
from pathlib import Path

import matplotlib

from docs.files import put
from docs.kept import kept
from symfric.report.study.data import plain
from symfric.report.study.drawing.axes import png
from symfric_evidence.sources.gallery import VERDICTS
from symfric_evidence.sources.registry import SOURCES, title
from symfric_evidence.sources.reproduction import NOT_MADE, reproductions


def write(folder: Path) -> None:
    """Compute the figures whose sources have changed, and write a page for each source."""
    matplotlib.use("Agg")
    maker = Path(__file__).read_text(encoding="utf-8")
    made = {
        name: kept(folder / "made" / f"{name}.json", name + maker, lambda n=name, e=entry: plain(_make(n, e, folder)))
        for name, entry in reproductions().items()
    }
    rows = ["| source | figures and tables | true | false | true only if |", "|---|---:|---:|---:|---:|"]
    for source, words in SOURCES.items():
        own = {name: m for name, m in made.items() if name.startswith(f"{source}-")}
        verdicts = Counter(VERDICTS[f["holds"]] for m in own.values() for f in m["findings"])
        counted = " | ".join(str(verdicts[v]) for v in VERDICTS.values())
        rows.append(f"| [{words}]({source}.md) | {len(own)} | {counted} |")
        put(folder / f"{source}.md", _page(source, own))
    text = (folder / "index.in.md").read_text(encoding="utf-8").replace("<!-- counts -->", "\n".join(rows))
    put(folder / "index.md", text + "\n```{toctree}\n:hidden:\n\n" + "\n".join(SOURCES) + "\n```\n")


def _make(name: str, entry, folder: Path) -> dict:
    import matplotlib.pyplot as plt

    made = entry.make()
    if made.figure is not None:
        place = folder / "made" / f"{name}.png"
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(png(made.figure))
        plt.close("all")
    return {
        "caption": entry.caption,
        "picture": made.figure is not None,
        "text": made.text,
        "findings": [asdict(f) for f in made.findings],
    }


def _page(source: str, made: dict[str, dict]) -> str:
    parts = [f"# {SOURCES[source]}\n"]
    for name, m in made.items():
        parts.append(f"({name})=\n## {title(name)}\n\n{m['caption']}\n")
        if m["picture"]:
            parts.append(f"```{{image}} made/{name}.png\n:alt: {title(name)}\n```\n")
        if m["text"]:
            parts.append(f"```text\n{m['text'].rstrip()}\n```\n")
        if m["findings"]:
            rows = [f"| {_cell(f['claim'])} | {VERDICTS[f['holds']]} | {_cell(f['found'])} |" for f in m["findings"]]
            parts.append("\n".join(["| the source | | found |", "|---|---|---|", *rows]) + "\n")
        parts.append(f"```sh\nsymfric reproduce {name}\n```\n")
    parts += [f"Not made: `{name}`, {why}.\n" for name, why in NOT_MADE.items() if name.startswith(f"{source}-")]
    return "\n".join(parts)


def _cell(text: str) -> str:
    """Return a text for a table of Markdown, where | ends a cell and a lone * or _ would mean emphasis."""
    for letter in "\\|*_<$":
        text = text.replace(letter, "\\" + letter)
    return text
