"""What `plot()` and a notebook show of recordings, trajectories, experiments, hands, diagnoses.

Plots are pyplot's, so that a script's `show()` and a notebook find them.
"""

from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from hannes.core.errors import BadInput, nearest
from hannes.report import style
from hannes.report.figure_diagnosis import drawn_recording
from hannes.report.schematic import schematic

if TYPE_CHECKING:
    from hannes.core.recording.recording import Recording
    from hannes.report.diagnosed import Diagnosis
    from hannes.simulation.experiment.experiment import Experiment
    from hannes.simulation.hand.hand import Hand
    from hannes.simulation.trajectory import Trajectory

Axes = np.ndarray  # of matplotlib's axes, shape (panels,)
OUTPUTS = ("position", "current", "duty", "force", "leader_tension")


def recording_plot(recording: "Recording", channels: str | Sequence[str] = ()) -> Axes:
    """Draw channels over time, one panel each; the reference in the panel of the position.

    `channels`: a name or names (default: all). Returns matplotlib's axes, shape (panels,). Raises
    BadInput for a channel that the recording does not have.
    """
    shown = _named(channels) or [n for n in recording.names if n != "reference"]
    shown = shown or list(recording.names)
    columns = {name: recording[name] for name in shown}
    axes = _panels(recording.time, columns, recording.units)
    if "position" in shown and "reference" in recording:
        panel = axes[shown.index("position")]
        panel.plot(recording.time, recording["reference"], **style.MARK, label="reference")
        panel.legend(loc="best")
    return axes


def trajectory_plot(trajectory: "Trajectory", channels: str | Sequence[str] = ()) -> Axes:
    """Draw outputs or states over time, one panel each; of several numbers one line each.

    `channels`: a name or names (default: position, current, duty, force, leader tension). Returns
    matplotlib's axes, shape (panels,). Raises BadInput for an unknown name.
    """
    compiled = trajectory.compiled
    units = {slot.name: slot.unit for slot in (*compiled.states.slots, *compiled.outputs.slots)}
    columns = {}
    for name in _named(channels) or OUTPUTS:
        if name not in units:
            raise BadInput(f'a trajectory has no "{name}"{nearest(name, units)}')
        columns[name] = trajectory[name]
    return _panels(trajectory.time, columns, units)


def diagnosis_plot(diagnosis: "Diagnosis", channels: str | Sequence[str] = ()) -> Axes:
    """Draw one recording as measured, before and after, one panel a channel.

    It is the first that no fit has seen, where there is one. `channels`: a name or names (default:
    all that are judged). Returns matplotlib's axes, shape (panels,). Raises BadInput for an
    unknown name.
    """
    traces = drawn_recording(diagnosis)
    shown = _named(channels) or list(traces.measured)
    for name in shown:
        if name not in traces.measured:
            raise BadInput(f'no channel "{name}" was judged{nearest(name, traces.measured)}')
    measured = {name: traces.measured[name] for name in shown}
    axes = _panels(traces.time, measured, diagnosis.plant.channels, color=style.BLACK)
    for name, panel in zip(shown, axes, strict=True):
        panel.lines[0].set_label("measured")
        panel.plot(traces.time, traces.before[name], **style.SECOND, label="before")
        panel.plot(traces.time, traces.after[name], **style.FIRST, label="after")
    axes[0].legend(loc="best")
    axes[0].set_title(f"{traces.entry.name}: {diagnosis.verdict.sentence}", wrap=True)
    return axes


def _named(channels: str | Sequence[str]) -> list[str]:
    """Names as a list; one name may stand alone."""
    return [channels] if isinstance(channels, str) else list(channels)


def recording_html(recording: "Recording") -> str:
    """A table of the channels: unit, least and greatest value."""
    origin = f"{recording.source}, plant {recording.plant}" if recording.plant else recording.source
    span = f"{recording.time[0]:g} to {recording.time[-1]:g} s"
    rows = [
        (name, recording.units[name], f"{each.min():.4g}", f"{each.max():.4g}")
        for name, each in recording.items()
        if name != "time"
    ]
    caption = f"Recording ({origin}): {len(recording)} samples, {span}"
    return _table(caption, ("channel", "unit", "least", "greatest"), rows)


def trajectory_html(trajectory: "Trajectory") -> str:
    """A table of what the hand did: outcome and the range of the main outputs."""
    title, span = trajectory.experiment.title, f"{len(trajectory.time)} samples"
    outputs = trajectory.compiled.outputs
    rows = [
        (
            name,
            outputs.slot(name).unit,
            f"{trajectory[name].min():.4g}",
            f"{trajectory[name].max():.4g}",
        )
        for name in OUTPUTS
        if trajectory.time.size
    ]
    caption = f"Trajectory of {title}: {trajectory.outcome.value}, {span}"
    return _table(caption, ("output", "unit", "least", "greatest"), rows)


def diagnosis_html(diagnosis: "Diagnosis") -> str:
    """The sentence, and the gap of each channel before and after."""
    stages = ("as_given", "before", "after", "floor")
    rows = [
        (name, gap["unit"], *(f"{gap[stage]:.3g}" for stage in stages))
        for name, gap in diagnosis.verdict.gap.items()
    ]
    sentence = f"<p><strong>{escape(diagnosis.verdict.sentence)}</strong></p>"
    columns = ("RMS gap", "unit", "as given", "before", "after", "noise floor")
    return sentence + _table(f"On {diagnosis.verdict.gap_on}", columns, rows)


def hand_html(hand: "Hand") -> str:
    """The hand's schematic; parts at which its effects sit stand out."""
    names = [each.name for each in hand.present_effects()]
    words = f"effects: {', '.join(names)}" if names else "no effects beyond the base model"
    return f'<div style="max-width:56em">{schematic(hand, names)}<p>{escape(words)}</p></div>'


def experiment_html(experiment: "Experiment") -> str:
    """A table of what is done with the hand."""
    times, angles = experiment.reference.knots
    thing = experiment.object
    rows = [
        ("duration", f"{experiment.duration:g} s"),
        ("reference", f"{angles.min():g} to {angles.max():g} rad, {times.size} points"),
        ("object", "none" if thing is None else thing.shape),
        ("force sensor", "yes" if thing is not None and thing.sensor else "no"),
        ("controller", experiment.controller),
        ("sampling", f"{experiment.sampling:g} Hz"),
        *((f"noise of {name}", f"{spread:g}") for name, spread in experiment.noise.items()),
    ]
    values = {**(thing.values if thing else {}), **experiment.values}
    rows += [(name, f"{value:g}") for name, value in values.items()]
    return _table(f"Experiment: {experiment.title}", ("what", "value [SI]"), rows)


def _panels(
    time: np.ndarray, columns: Mapping[str, np.ndarray], units: Mapping[str, str], **look: Any
) -> Axes:
    """One panel a channel, in the project's style."""
    import matplotlib.pyplot as plt

    # Outside of the style: where this loads a notebook's backend, what that sets has to stay.
    size = (6.4, 1.5 * len(columns) + 0.6)
    figure = plt.figure(figsize=size, layout="constrained")
    with style.styled():
        axes = figure.subplots(len(columns), 1, sharex=True, squeeze=False)
        for panel, (name, values) in zip(axes[:, 0], columns.items(), strict=True):
            panel.plot(time, values, **({"color": style.BLUE} if values.ndim == 1 else {}) | look)
            unit = units[name]
            panel.set_ylabel(name.replace("_", " ") + (f" [{unit}]" if unit != "1" else ""))
        axes[-1, 0].set_xlabel("time [s]")
    return axes[:, 0]


def _table(caption: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A small table in HTML."""
    head = "".join(f"<th>{escape(each)}</th>" for each in columns)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )
    return f"<table><caption>{escape(caption)}</caption><tr>{head}</tr>{body}</table>"
