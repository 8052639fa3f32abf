"""Figures of a diagnosis: traces with their residual, the map of residuals, the ranking."""

from typing import TYPE_CHECKING, Any

import numpy as np

from hannes.report import style
from hannes.report.figure import Drawn, drawn
from hannes.report.formats import decimals, number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from hannes.identification.residuals import Traces
    from hannes.report.diagnosed import Diagnosis

MEASURED: dict[str, Any] = {"color": style.BLACK, "linewidth": 2.4, "alpha": 0.35}
NOMINAL: dict[str, Any] = {"color": style.GREY, "linestyle": (0, (1, 1.2)), "linewidth": 1.2}
RANKED = 12  # effects that are drawn, the best
POINTS = 900  # of a drawn line; between them its extremes are kept


def figures(diagnosis: "Diagnosis") -> list[Drawn]:
    """One figure for each judged channel of the recording that is drawn, then map and ranking."""
    traces = drawn_recording(diagnosis)
    made = [_channel(diagnosis, traces, name) for name in traces.measured]
    if diagnosis.verdict.where:
        made.append(_where(diagnosis))
    if diagnosis.verdict.candidates:
        made.append(_ranking(diagnosis))
    return made


def drawn_recording(diagnosis: "Diagnosis") -> "Traces":
    """The recording that is drawn: of those in role show, else of all, the furthest off."""
    shown = [each for each in diagnosis.traces if each.entry.role == "show"]
    return max(shown or diagnosis.traces, key=lambda each: _furthest(diagnosis, each))


def _furthest(diagnosis: "Diagnosis", traces: "Traces") -> float:
    """What the baseline leaves in the channel where that is most, in noise floors."""
    if not traces.mask.any():
        return 0.0
    misses = {n: (traces.before[n] - traces.measured[n])[traces.mask] for n in traces.measured}
    noise_floors = diagnosis.noise_floors
    found = (
        np.sqrt(np.mean(misses[n] ** 2)) / floor for n, floor in noise_floors.items() if n in misses
    )
    return float(max(found, default=0.0))


def _channel(diagnosis: "Diagnosis", traces: "Traces", name: str) -> Drawn:
    unit, gap = diagnosis.plant.channels[name], diagnosis.verdict.gap
    caption = f"Recording {traces.entry.name} ({traces.entry.condition}), role {traces.entry.role}."
    alt = f"{name} over time, measured and simulated."
    if name in gap:
        sizes = [f"{gap[name][key]:.3g}" for key in ("as_given", "before", "after", "floor")]
        alt += " RMS gap as given {}, before the result {}, result {}, noise floor {} {}.".format(
            *sizes, unit
        )
    noise_floor = diagnosis.noise_floors[name]

    def draw() -> "Figure":
        figure, (above, below) = style.panels(2)
        before = "before: baseline refitted" if diagnosis.verdict.refit_taken else "before"
        _traces(above, traces, name, _labelled(name, unit), before)
        _left(below, traces, name, noise_floor, _labelled("residual", unit))
        below.set_xlabel("time [s]")
        return figure

    title = f"{name.capitalize()}: measured, before and after"
    return drawn(f"diagnosis-{name}", title, caption, alt, draw)


def _labelled(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit != "1" else name


def _traces(axes: "Axes", traces: "Traces", name: str, label: str, before: str) -> None:
    lines = (
        ("measured", traces.measured, MEASURED),
        ("as given", traces.as_given, NOMINAL),
        (before, traces.before, style.SECOND),
        ("after", traces.after, style.FIRST),
    )
    for text, channels, look in lines:
        axes.plot(*thinned(traces.time, channels[name]), label=text, **{**look, "zorder": 2})
    axes.set_ylabel(label)
    style.legend(axes)


def _left(axes: "Axes", traces: "Traces", name: str, noise_floor: float, label: str) -> None:
    """Simulated minus measured, with the noise floor as a band."""
    axes.axhspan(
        -noise_floor, noise_floor, color=style.GREY, alpha=0.25, linewidth=0, label="noise floor"
    )
    for text, channels, look in (
        ("before", traces.before, style.SECOND),
        ("after", traces.after, style.FIRST),
    ):
        difference = np.where(traces.mask, channels[name] - traces.measured[name], np.nan)
        axes.plot(*thinned(traces.time, difference), label=text, **{**look, "linewidth": 1.1})
    axes.set_ylabel(label)
    style.legend(axes, ncols=3)


def thinned(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return at most about POINTS points that keep every extreme, shapes (m,)."""
    width = -(-2 * time.size // POINTS)
    if width <= 2:
        return time, values
    kept = []
    for start in range(0, time.size, width):
        part = values[start : start + width]
        if np.isnan(part).all():
            kept.append(start)
        else:
            kept += sorted({start + int(np.nanargmin(part)), start + int(np.nanargmax(part))})
    return time[kept], values[kept]


def _where(diagnosis: "Diagnosis") -> Drawn:
    rows = diagnosis.verdict.where[::-1]
    names = [f"{row['channel']}, {row['phase']}" for row in rows]
    sizes = [row["times_floor"] for row in rows]

    def draw() -> "Figure":
        figure, (axes,) = style.panels(1, 0.5 + 0.22 * len(rows))
        axes.barh(names, sizes, color=style.VERMILLION, height=0.6)
        axes.axvline(1.0, **style.MARK)
        axes.set_xlabel("RMS residual of the baseline, in noise floors")
        axes.grid(axis="y", visible=False)
        return figure

    worst = diagnosis.verdict.where[0]
    alt = (
        f"Worst in the fitted recordings: {worst['channel']} while {worst['phase']}, "
        f"{number(worst['times_floor'], 2)} times the noise floor."
    )
    return drawn(
        "diagnosis-where", "In the fitted recordings", f"{alt} Dotted: the noise floor.", alt, draw
    )


def _ranking(diagnosis: "Diagnosis") -> Drawn:
    rows = diagnosis.verdict.candidates[:RANKED][::-1]
    names = [row["effect"].rpartition(":")[2] for row in rows]
    shares = [100.0 * row["gain_select"] for row in rows]
    chosen = diagnosis.verdict.effects

    def draw() -> "Figure":
        figure, (axes,) = style.panels(1, 0.6 + 0.3 * len(rows))
        colours = [style.BLUE if row["effect"] in chosen else style.GREY for row in rows]
        axes.barh(names, shares, color=colours, height=0.6)
        for place, share in enumerate(shares):  # right of the axis, also where it explains nothing
            axes.annotate(
                f"{decimals(round(share), 0)} %",
                (max(share, 0.0), place),
                xytext=(3, 0),
                textcoords="offset points",
                va="center",
            )
        axes.set_xlabel("reducible gap that it explains [%]")
        axes.set_xlim(min(0.0, *shares), max(10.0, *shares) * 1.15)
        axes.grid(axis="y", visible=False)
        return figure

    alt = "; ".join(
        f"{n} {decimals(round(g), 0)} %" for n, g in zip(names[::-1], shares[::-1], strict=True)
    )
    caption = "Of the reducible gap: what the refitted baseline leaves above the noise floor."
    caption += " Blue: what the verdict names." if chosen else " None is named."
    return drawn("diagnosis-ranking", "What each effect would explain", caption, alt, draw)
