"""Figures 2 to 8 and tables 1 and 2 of the study of scaled rolling isolation."""

from dataclasses import replace
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from symfric.motions import Motion
from symfric.motions.synthetic import eurocode8
from symfric.theory.scaling import factors
from symfric_evidence.sources.panels import FigureData, Panel, PanelCurve, figure_entry
from symfric_evidence.sources.registry import Entry, Finding, Inputs
from symfric_evidence.sources.rolling.judgements import findings_of
from symfric_evidence.sources.rolling.study import (
    MASS_OF_TABLE_2,
    SCALES,
    frictions,
    models,
    rolling_study,
    synthetic_set,
)
from symfric_evidence.sources.rolling.table3 import PRINTED, Table3, plot_table_3, table_3

if TYPE_CHECKING:
    import xarray as xr

PERIODS = np.geomspace(0.05, 4.0, 80)
RESPONSES = {
    "peak_acceleration": "(a) acceleration",
    "peak_velocity": "(b) relative velocity",
    "peak_displacement": "(c) relative displacement",
    "residual": "(d) residual displacement",
}
PGA, RATIO = "peak ground acceleration [g]", "returned ratio RR"
ARTIFICIAL = "artificial motions"
CASES = {  # figure: table, whether gravity is scaled, friction, whether its positions are
    "rolling-4": ("table 1", True, "case 1", False),
    "rolling-5": ("table 1", True, "case 3", False),
    "rolling-6": ("table 1", True, "case 3", True),
    "rolling-7": ("table 1", False, "case 1", False),
    "rolling-8": ("table 2", False, "case 1", False),
}
ROWS = {  # of tables 1 and 2: row, and what is printed for 1:4 to 1:19 in each; None where both say the same
    "mass": ("0.0156 0.00292 0.001 0.000455 0.000244 0.000146", "0.00816 0.00816 0.00816 0.00816 0.00816 0.00816"),
    "density": ("1 1 1 1 1 1", "0.522 2.800 8.163 17.934 33.436 55.990"),
    "force": ("0.0625 0.0204 0.01 0.00592 0.00391 0.00277", None),
    "damping": ("0.0625 0.0204 0.01 0.00592 0.00391 0.00277", "0.0452 0.0341 0.0286 0.0251 0.0226 0.0207"),
    "time": ("0.25 0.143 0.1 0.0769 0.0625 0.0526", "0.181 0.239 0.286 0.326 0.361 0.394"),
    "velocity": ("1 1 1 1 1 1", "1.384 0.598 0.350 0.236 0.173 0.134"),
    "acceleration": ("4 7 10 13 16 19", "7.656 2.5 1.225 0.725 0.479 0.339"),
}


@cache
def _artificial() -> tuple[Motion, ...]:
    return synthetic_set()


def _motions(inputs: Inputs) -> tuple[Motion, ...]:
    return _artificial() if inputs.motions is None else tuple(inputs.motions)


def _origin(inputs: Inputs) -> str:
    return ARTIFICIAL if inputs.motions is None else "the records given"


def figure_2(_inputs: Inputs) -> FigureData:
    """Return the three friction distributions of an even floor."""
    curves, findings = [], []
    for k, (name, profile) in enumerate(list(frictions().items())[:3]):
        if isinstance(profile, float):
            curves.append(PanelCurve(name, np.array([-2.0, 2.0]), np.array([profile, profile])))
            continue
        edges, values = map(np.asarray, profile)
        curves.append(PanelCurve(name, np.repeat(edges, 2)[1:-1], np.repeat(values, 2), k))
        words = f"mean {values.mean():.6f}, deviation {values.std():.6f}, {values.min():.4f} to {values.max():.4f}"
        deviation, reach = {1: (0.000815, 0.001), 2: (0.002355, 0.004)}[k]
        off = max(abs(values.mean() - 0.005), abs(values.std() - deviation), np.max(np.abs(values - 0.005)) - reach)
        claim = f"{name}: mean 0.005, deviation {deviation:g} within {reach:g}"
        findings.append(Finding(claim, words, bool(off < 1e-12)))
    findings.append(Finding("floors of cases 2 and 3", "neither cells nor draw are printed: 81 cells of 4 m, by seed"))
    panel = Panel("", "position $u$ [m]", r"$\mu$", tuple(curves), x_range=(-2, 2), y_range=(0, 0.011))
    return FigureData("rolling-2", "Coefficient of rolling friction over the floor.", (panel,), 1, tuple(findings))


def figure_3(inputs: Inputs) -> FigureData:
    """Return the spectra of the motions, their mean and the target."""
    motions = _motions(inputs)
    spectra = [m.spectrum(PERIODS).pseudo_acceleration for m in motions]
    single = [s / m.pga for s, m in zip(spectra, motions, strict=True)]
    mean = np.mean(spectra, axis=0)
    mean = mean / mean[0] * np.mean([s[0] for s in single])
    target = eurocode8(PERIODS)
    curves = [PanelCurve("single motions", PERIODS, s, 1, dash="dotted") for s in single]
    curves += [
        PanelCurve("mean", PERIODS, mean),
        PanelCurve("target, EN 1998-1", PERIODS, target / target[0] * mean[0], 2, dash="dashed"),
    ]
    off = float(np.max(np.abs(mean / (target / target[0] * mean[0]) - 1)))
    finding = Finding(
        "the mean spectrum matches the target, JTJ 004-89, well",
        f"neither the target nor the 20 records are printed; {_origin(inputs)} here, within {100 * off:.0f} %",
    )
    panel = Panel("", "period [s]", "pseudo-acceleration over PGA", tuple(curves), log="both")
    caption = f"Response spectra, damping ratio 0.05: {len(motions)} motions, {_origin(inputs)}."
    return FigureData("rolling-3", caption, (panel,), 1, (finding,))


def ratios(name: str, inputs: Inputs) -> FigureData:
    """Return the returned ratios of one of figures 4 to 8."""
    table, scaled, friction, moved = CASES[name]
    against = [
        m for m in models() if m.name == "prototype" or (m.name.startswith(table) and m.scaled_gravity == scaled)
    ]
    study = rolling_study(
        _motions(inputs),
        dampings=(1e5,) if scaled else (1e5, 2e5),
        profiles={friction: frictions()[friction]},
        against=against,
        scaled_positions=moved,
        progress=lambda done, of: inputs.progress(done / of),
    )
    models_ = study.isel(friction=0, model=slice(1, None))
    part = models_.isel(damping=0)
    panels = [_ratio_panel(part[f"ratio_{k}"], words) for k, words in RESPONSES.items()]
    if name not in ("rolling-4",):
        narrow = replace(panels[3], title="(e) residual displacement, main points", y_range=(0, 3))
        # single ratios of up to 50 would press all others on the axis
        panels = [*panels[:3], replace(panels[3], log="" if panels[3].y_range else "y"), narrow]
    words = f"{friction}, C = 100 kN s/m, {table}, gravity {'of the model' if scaled else 'unscaled'}"
    moved_words = ", positions of the friction scaled" if moved else ""
    caption = f"{words}{moved_words}; {_origin(inputs)}. Lines: medians."
    return FigureData(name, caption, tuple(panels), 2, findings_of(name, models_, _motions(inputs)))


def _ratio_panel(ratio: "xr.DataArray", title: str) -> Panel:
    """Return the ratios of all motions against the intensity: a column of points for each model, and its median."""
    curves = []
    for k, model in enumerate(ratio.model.values):
        sizes = np.abs(ratio.sel(model=model).values)  # motion, pga
        x = ratio.pga.values + 0.012 * (k - 2.5)
        name = model.split(", ")[1]
        curves.append(
            PanelCurve("", np.broadcast_to(x, sizes.shape).ravel(), sizes.ravel(), k, dash="none", marker=".")
        )
        curves.append(PanelCurve(name, x, np.nanmedian(sizes, axis=0), k))
    off = np.nanmax(np.abs(np.abs(ratio.values) - 1))
    return Panel(title, PGA, RATIO, tuple(curves), y_range=(0.9, 1.1) if off < 0.05 else None, levels=(("", 1.0),))


def scale_table(number: int) -> tuple[str, list[dict[str, object]], float]:
    """Return table 1 or 2 as text and as rows, and by how many units of its last digit the print is off at most."""
    factors_of = [factors(float(L), mass=None if number == 1 else MASS_OF_TABLE_2) for L in SCALES]
    head = f"{'quantity':20}" + "".join(f"{f'1:{L}':>11}" for L in SCALES)
    rows: list[dict[str, object]] = []
    lines, off = [head], 0.0
    for name in factors_of[0].to_dict():
        values = [getattr(f, name) for f in factors_of]
        lines.append(f"{name:20}" + "".join(f"{v:11.4g}" for v in values))
        rows.append({"quantity": name, "values": [float(v) for v in values]})
        printed = ROWS.get(name)
        if printed is not None:
            said = (printed[number - 1] or printed[0]).split()
            off = max(
                off, *(abs(float(s) - v) / 10.0 ** -len(s.partition(".")[2]) for s, v in zip(said, values, strict=True))
            )
    return "\n".join(lines) + "\n", rows, off


def _table_findings(table: tuple[str, list[dict[str, object]], float]) -> tuple[Finding, ...]:
    return (
        Finding(
            "the factors as printed", f"off by at most {table[2]:.1f} units of the last printed digit", table[2] < 1.01
        ),
    )


def _table_3_findings(table: Table3) -> tuple[Finding, ...]:
    claim = "the range of RR becomes less with the damping constant C"
    widths = {k: np.ptp(v, axis=1) for k, v in table.ranges.items()}
    said = {k: np.ptp(np.array(v), axis=1) for k, v in PRINTED.items()}
    cases = ("case 2", "case 3")
    computed, printed = (sum(int(np.sum(w[2e5, c] < w[1e5, c])) for c in cases) for w in (widths, said))
    words = f"{computed} of 8 ranges computed here become less, {printed} of the 8 printed ones"
    return (Finding(claim, words, computed == 8),)


def _scale_entry(number: int) -> Entry[Any]:
    caption = (
        "Scale factors of models of the prototype's density."
        if number == 1
        else "Scale factors of models of equal mass."
    )
    return Entry(
        caption,
        lambda _inputs: scale_table(number),
        text=lambda table: table[0],
        plain=lambda table: table[1],
        findings=_table_findings,
    )


def _ratio_entry(name: str) -> Entry[Any]:
    table, scaled, friction, moved = CASES[name]
    gravity = "scaled" if scaled else "unscaled"
    caption = f"Returned ratios: {friction}, {table}, gravity {gravity}{', positions scaled' if moved else ''}."
    return figure_entry(caption, partial(ratios, name), takes_records=True)


FIGURES = {
    "rolling-2": figure_entry("Three friction distributions of a floor.", figure_2),
    "rolling-3": figure_entry("Spectra of the motions, their mean and the target.", figure_3, takes_records=True),
    **{name: _ratio_entry(name) for name in CASES},
    "rolling-table-1": _scale_entry(1),
    "rolling-table-2": _scale_entry(2),
    "rolling-table-3": Entry(
        "Returned ratios of scaled models, from 40 000 runs; --records names a folder of AT2 files.",
        lambda inputs: table_3(_motions(inputs), lambda done, of: inputs.progress(done / of)),
        plot_table_3,
        text=lambda table: table.text(),
        plain=lambda table: table.rows(),
        findings=_table_3_findings,
        takes_records=True,
    ),
}
