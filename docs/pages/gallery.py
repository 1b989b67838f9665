"""The gallery: every example with what it prints and a picture, and every scene file with its study."""

import base64
import contextlib
import io
import runpy
from dataclasses import asdict, dataclass
from itertools import chain
from pathlib import Path

import matplotlib

from docs.files import put
from docs.kept import kept
from symfric.report.study.drawing.axes import png

EXAMPLES = Path(__file__).parents[2] / "examples"
_PRINTED = '''"""What the script prints."""
import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
ax.set_axis_off()
ax.text(0, 1, printed, family="monospace", fontsize=7, va="top")
'''  # the picture of a script without one of its own in gallery/pictures


@dataclass(frozen=True)
class Shown:
    """What a page of the gallery shows.

    Attributes
    ----------
    title, words : str
    printed : str
    picture, alt : str
        File of the picture, in the folder of the page.
    code : str
        Of the picture; empty for a scene file.
    """

    title: str
    words: str
    printed: str
    picture: str
    alt: str
    code: str = ""


def write(folder: Path) -> None:
    """Write a page for each example, and the gallery of their pictures."""
    matplotlib.use("Agg")
    scripts = {p.stem: p for p in sorted(EXAMPLES.glob("*.py"))}
    files = {p.stem: p for p in sorted(EXAMPLES.glob("*.toml"))}
    tiles: dict[str, list[str]] = {"scripts": [], "files": []}
    for kind, paths, run, page in (("scripts", scripts, _script, _page), ("files", files, _file, _study_page)):
        for name, path in paths.items():
            shown = _kept(folder / "made" / f"{name}.json", path, lambda n=name, p=path, r=run: r(n, p, folder))
            put(folder / f"{name}.md", page(name, shown, path))
            tiles[kind].append(_tile(name, shown))
    text = (folder / "index.in.md").read_text(encoding="utf-8")
    for kind, found in tiles.items():
        text = text.replace(f"<!-- {kind} -->", '<div class="tiles">\n' + "\n".join(found) + "\n</div>\n")
    names = "\n".join(f"{name.replace('_', ' ').capitalize()} <{name}>" for name in [*scripts, *files])
    put(folder / "index.md", f"{text}\n```{{toctree}}\n:hidden:\n\n{names}\n```\n")


def _kept(place: Path, source: Path, make) -> Shown:
    """Return what was made before from the same text and sources, else make it."""
    picture = place.parents[1] / "pictures" / source.name
    text = source.read_text(encoding="utf-8") + (picture.read_text(encoding="utf-8") if picture.is_file() else "")
    maker = Path(__file__).read_text(encoding="utf-8")
    return Shown(**kept(place, text + maker, lambda: asdict(make()), data=True))


def _script(name: str, path: Path, folder: Path) -> Shown:
    """Run a script, then the code of its picture with the names it left."""
    import matplotlib.pyplot as plt

    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        names = runpy.run_path(str(path), run_name="__main__")
    drawing = folder / "pictures" / f"{name}.py"
    code = (drawing.read_text(encoding="utf-8") if drawing.is_file() else _PRINTED).split('"""', 2)
    names["printed"] = printed.getvalue()
    image = f"made/{name}.png"
    with matplotlib.rc_context({"figure.constrained_layout.use": True, "figure.figsize": (6.4, 3.8)}):
        exec(compile(code[2], str(drawing), "exec"), names)
        (folder / "made").mkdir(parents=True, exist_ok=True)
        (folder / image).write_bytes(png(plt.gcf()))
    plt.close("all")
    title, _, words = (names["__doc__"] or name).strip().partition("\n\n")
    shown = code[2].strip() if drawing.is_file() else ""
    return Shown(" ".join(title.split()), words, printed.getvalue(), image, code[1].strip(), shown)


def _file(name: str, path: Path, folder: Path) -> Shown:
    """Study a scene file; keep its page, the data beside it, and one picture."""
    from symfric.report.study.data import data_files
    from symfric.report.study.page import page, summary
    from symfric.report.study.sections import motion, sweep
    from symfric.report.study.study import study
    from symfric.scenefile import read_scene_file

    with contextlib.chdir(EXAMPLES.parent):  # the page names the file as it is read, the same on every machine
        result = study(read_scene_file(path.relative_to(EXAMPLES.parent)))
    picture = next(chain(sweep.pictures(result), motion.pictures(result.motion.found, result.file)))
    image = f"made/{name}.svg"
    (folder / "made").mkdir(parents=True, exist_ok=True)
    (folder / image).write_bytes(base64.b64decode(picture.uri.partition(",")[2]))
    for file, text in {"study.html": page(result), **data_files(result)}.items():
        put(folder / "extra" / "studies" / name / file, text)
    words = " ".join((result.file.description or "").split())
    short = "\n".join(summary(result))
    return Shown(result.file.title or name, words, short, image, picture.alt)


def _tile(name: str, shown: Shown) -> str:
    return f'<a href="{name}.html"><img src="../_images/{Path(shown.picture).name}" alt="" loading="lazy"><span>{shown.title}</span></a>'  # noqa: E501


def _page(name: str, shown: Shown, path: Path) -> str:
    return "\n".join(
        [
            f"# {shown.title}\n",
            f"{shown.words}\n",
            f"```{{image}} {shown.picture}\n:alt: {shown.alt}\n```\n",
            f"{{download}}`examples/{name}.py <../../examples/{name}.py>` prints:\n",
            f"```text\n{shown.printed.strip()}\n```\n",
            f"```{{literalinclude}} ../../examples/{name}.py\n:language: python\n```\n",
            f"The picture:\n\n```python\n{shown.code}\n```\n" if shown.code else "",
        ]
    )


def _study_page(name: str, shown: Shown, path: Path) -> str:
    return "\n".join(
        [
            f"# {shown.title}\n",
            f"{shown.words}\n",
            f"```{{image}} {shown.picture}\n:alt: {shown.alt}\n```\n",
            f"```sh\nsymfric study examples/{name}.toml\n```\n",
            f"```text\n{shown.printed.strip()}\n```\n",
            f'The <a href="../studies/{name}/study.html">page of this study</a>. The file, '
            f"{{download}}`examples/{name}.toml <../../examples/{name}.toml>`:\n",
            f"```{{literalinclude}} ../../examples/{name}.toml\n:language: toml\n```\n",
        ]
    )
