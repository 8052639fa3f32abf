"""`hannes view`: recordings as a hand in motion, in one page; and stills of it."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from hannes.core.errors import BadInput
from hannes.core.io.atomic_files import write_bytes, write_text
from hannes.core.io.outputs import reserved
from hannes.core.recording.recording import Recording
from hannes.report.viewer.page import page
from hannes.report.viewer.replay import Replay, replay, without_effects
from hannes.report.viewer.scene import Scene, scene
from hannes.report.viewer.still import still_files
from hannes.simulation.hand.hand import Hand
from hannes.simulation.hand.hand_file import load_hand

SHOWN = ("position", "current", "duty", "force")


def view(
    files: Sequence[str | Path],
    out: str | Path = "results/view.html",
    *,
    hands: Sequence[str | Path] = (),
    stills: Sequence[float] = (),
    force: bool = False,
) -> dict[str, Any]:
    """Write a page that shows one recording, or two of them in one picture; return what it shows.

    A recording has no joint angles: it is drawn by a simulation of its experiment with its own
    hand, or with `hands` (hand.toml files, one for all recordings or one for each). A hand with
    effects is simulated without them too. stills: times [s] of which to write an SVG and a PNG
    beside the page. `force`: files of another command are replaced, too. Raises BadInput for what
    is no recording of a hand, ComputationFailed where a simulation does not end.
    """
    target = Path(out)
    if target.suffix.lower() != ".html":
        raise BadInput(f"{out}: expected a file named .html for the page")
    stilled = [_still_place(target, time, each) for time in stills for each in (".svg", ".png")]
    with reserved("view", [target, *stilled], [*files, *hands], force=force):
        return _viewed(files, target, hands, stills)


def _viewed(
    files: Sequence[str | Path],
    target: Path,
    hands: Sequence[str | Path],
    stills: Sequence[float],
) -> dict[str, Any]:
    recordings = [Recording.read(each) for each in _few(files)]
    chosen: list[Hand | None] = [load_hand(each) for each in hands]
    if len(chosen) not in (0, 1, len(recordings)):
        raise BadInput(
            f"{len(chosen)} hands for {len(recordings)} recordings: give one, or as many"
        )
    own = [*chosen, *chosen][: len(recordings)] or [None, None]
    replays = [replay(each, hand) for each, hand in zip(recordings, own, strict=False)]
    names = _names([Path(each) for each in files])
    scenes = [_scene(each, name) for each, name in zip(replays, names, strict=True)]
    bare = without_effects(replays[-1])
    without = _bare(bare, names[-1]) if bare else None
    _check_times(stills, scenes[0])
    text = page(", ".join(names), scenes, without)
    target.parent.mkdir(parents=True, exist_ok=True)
    write_text(target, text)
    drawn = [*scenes, without] if without else scenes
    return {
        "out": str(target),
        "bytes": target.stat().st_size,
        "recordings": [{"name": each.name, "note": each.note} for each in drawn],
        "stills": [path for time in stills for path in _still(target, drawn, time)],
    }


def _few(files: Sequence[str | Path]) -> Sequence[str | Path]:
    if not 1 <= len(files) <= 2:
        raise BadInput(f"{len(files)} recordings: a page shows one, or two in one picture")
    return files


def _names(files: Sequence[Path]) -> list[str]:
    """Distinct names of the files: their own, with the folder where these are equal."""
    stems = [each.name.split(".")[0] for each in files]
    if len(set(stems)) == len(stems):
        return stems
    folders = [
        f"{each.resolve().parent.name}/{stem}" for each, stem in zip(files, stems, strict=True)
    ]
    return folders if len(set(folders)) == len(folders) else [f"{stems[0]} 1", f"{stems[1]} 2"]


def _scene(shown: Replay, name: str) -> Scene:
    """A recording with the simulation that draws it, and what is to be said of both."""
    made = scene(shown, name)
    measured = shown.recording.source == "measured"
    effects = [each.name for each in shown.hand.present_effects()]
    notes = ["measured" if measured else "simulated"]
    if measured:
        near = [
            f"{each} within {shown.gap(each):.2g} {shown.recording.units[each]} RMS"
            for each in SHOWN[:2]
            if each in shown.recording
        ]
        notes.append(
            f"a recording has no joint angles, so a simulation draws it ({', '.join(near)})"
        )
    notes += [f"with {', '.join(effects)}"] if effects else []
    if made.every > 1:
        notes.append(f"one of {made.every} samples of {len(shown.recording)} is shown")
    kept = (*SHOWN, "leader_tension") if measured else ("leader_tension",)
    simulated = {each: values for each, values in made.simulated.items() if each in kept}
    return replace(made, note="; ".join(notes), simulated=simulated)


def _bare(shown: Replay, name: str) -> Scene:
    """The same simulated without effects: nobody recorded it."""
    made = scene(shown, f"{name} without")
    kept = (*SHOWN, "leader_tension")
    simulated = {each: values for each, values in made.simulated.items() if each in kept}
    note = "simulated without the hand's effects"
    return replace(made, note=note, recorded={}, simulated=simulated)


def _check_times(stills: Sequence[float], first: Scene) -> None:
    for time in stills:
        if not first.time[0] <= time <= first.time[-1]:
            raise BadInput(
                f"no still at {time:g} s: the recording goes from {first.time[0]:g} to "
                f"{first.time[-1]:g} s"
            )


def _still_place(target: Path, time: float, suffix: str) -> Path:
    return target.with_name(f"{target.stem}-{time:.4g}s{suffix}")


def _still(target: Path, scenes: Sequence[Scene], time: float) -> list[str]:
    """Write one moment beside the page; return the names of the files."""
    found = []
    for suffix, content in still_files(scenes[:2], time).items():
        path = _still_place(target, time, suffix)
        write_bytes(path, content)
        found.append(str(path))
    return found
