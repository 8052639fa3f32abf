"""`hannes begin`: from unknown logs to a mapping, recordings and a campaign."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hannes.campaigns.begin.clock_choice import clock_of
from hannes.campaigns.begin.column_guess import (
    Guess,
    guesses,
    label_array,
    label_column,
    maybe_label,
)
from hannes.campaigns.begin.columns_seen import SeenArrays, array_columns, text_columns
from hannes.campaigns.begin.conditions import Condition, conditions
from hannes.campaigns.begin.long_guess import long_columns
from hannes.campaigns.begin.mapping_draft import FILL_IN, Draft
from hannes.campaigns.begin.mapping_text import draft
from hannes.campaigns.begin.runs_side_by_side import Grouped, grouped
from hannes.campaigns.begin.text_layout import text_layout
from hannes.campaigns.convert import Converted, convert
from hannes.campaigns.convert import write as write_recordings
from hannes.campaigns.foreign.sources import reader_of
from hannes.core.errors import BadInput
from hannes.core.io import atomic_files
from hannes.core.io.toml_table import read_text
from hannes.plants.protocol import Plant, find_plant

FloatArray = NDArray[np.float64]

MAPPING, CAMPAIGN, RECORDINGS = "mapping.toml", "campaign.toml", "recordings"


@dataclass
class Begun:
    """What was seen, what is to be filled in, and what was written."""

    out: Path
    seen: list[str] = field(default_factory=list)
    missing: list[str] = field(default_factory=list)
    recordings: list[Path] = field(default_factory=list)
    conditions: list[Condition] = field(default_factory=list)

    @property
    def next(self) -> str:
        """What to type or to edit next."""
        if self.missing:
            return f"fill in {self.out / MAPPING}, then run the same command again"
        return f"look at {self.out / CAMPAIGN}, then: hannes diagnose {self.out / CAMPAIGN}"


def begin(files: Sequence[str | Path], out: str | Path, plant: str = "hand") -> Begun:
    """Look at logs; write a mapping into the folder `out`, and where it is complete a campaign.

    A mapping that is there already, edited or not, is used as it is. Raises BadInput for files
    that cannot be read, or whose layouts differ.
    """
    paths = [Path(each) for each in files]
    if not paths:
        raise BadInput("no files given; expected logs, such as logs/*.csv")
    begun, machine = Begun(Path(out)), find_plant(plant)
    begun.out.mkdir(parents=True, exist_ok=True)
    mapping = begun.out / MAPPING
    if not mapping.exists():
        made = look(paths, machine)
        begun.seen, begun.missing = made.seen, made.missing
        atomic_files.write_text(mapping, made.text)
    elif left := _left(mapping):
        begun.missing = left
    if not begun.missing:
        _converted(begun, paths, mapping, plant)
    return begun


def look(paths: Sequence[Path], plant: Plant) -> Draft:
    """The mapping that fits the first file, as far as it is evident; the others must be alike."""
    first = paths[0]
    reader = reader_of(first)
    source = None if reader is None else reader(first, ())
    layout = text_layout(first) if source is None else None
    arrays = SeenArrays(text_columns(layout), [], []) if layout else array_columns(first, source)
    long = long_columns(first, layout, source, arrays.columns)
    known = tuple(name for name in plant.channels if name != "time")
    runs = grouped(arrays.columns, known) if layout is None else Grouped(arrays.columns, [], [])
    seen = long.columns if long is not None else runs.columns
    columns = {str(each.column): each.values for each in seen if each.values is not None}
    chosen, doubtful, clocks = _chosen(guesses(seen, known), columns)
    if layout is not None:
        split = label_column(layout.names, layout.rows)
    else:
        alone = long is None and not runs.said and not arrays.stacked
        split = _label(chosen, columns) if alone else ""
    made = draft(
        paths, plant.name, layout, chosen, doubtful, columns, split, _required(plant, chosen)
    )
    if layout is not None and not split:
        _ask_for_runs(made, plant.name, maybe_label(layout.names, layout.rows))
    if long is not None:
        made.insert(f'plant = "{plant.name}"', f"{long.line}  # a row a value")
        made.seen.append("a long table: a row a value")
        _fill_gaps(made, chosen, columns)
    if stacked := [name for name in arrays.stacked if _takes(chosen, name)]:
        made.stack(plant.name, stacked)
    if long is None:
        made.seen, made.missing = [*runs.said, *made.seen], [*made.missing, *runs.asked]
    if arrays.left:
        made.seen.append(f"not used: {', '.join(arrays.left)[:300]}; say by index which column")
    made.seen += clocks[0]
    made.missing += clocks[1]
    if layout is not None:
        for path in paths[1:]:
            if text_layout(path).names != layout.names:
                raise BadInput(
                    f"{path}: has other columns than {first.name}; begin with it alone, or, where "
                    "it belongs to the same runs, name it in the mapping under [files.NAME]"
                )
    return made


def _label(chosen: dict[str, Guess], columns: dict[str, FloatArray]) -> str:
    """The array that says which run each sample is of."""
    clock = columns.get(str(chosen["time"].column)) if "time" in chosen else None
    return label_array(columns, clock.size) if clock is not None else ""


def _ask_for_runs(made: Draft, plant: str, column: str) -> None:
    """Whether words with numbers name runs only a person knows: they may be states of one."""
    if column:
        made.ask(f'does "{column}" name runs? (split: the column, or delete that line)')
        line = f'split = "{FILL_IN}"  # a new run wherever "{column}" changes? else delete this'
        made.insert(f'plant = "{plant}"', line)


def _fill_gaps(made: Draft, chosen: dict[str, Guess], columns: dict[str, FloatArray]) -> None:
    """Signals of a long table that were recorded at other times than the clock's."""
    for channel, guess in chosen.items():
        if channel == "time" or np.isfinite(columns[str(guess.column)]).all():
            continue
        how = "hold" if channel == "reference" else "linear"
        made.insert(f"\n[channels.{channel}]", f'fill = "{how}"  # has gaps')
        made.seen.append(f'{channel} is not there at every time: fill = "{how}"')


def _takes(chosen: dict[str, Guess], column: str) -> bool:
    return any(guess.column == column for guess in chosen.values())


def _chosen(
    found: Sequence[Guess], columns: dict[str, FloatArray]
) -> tuple[dict[str, Guess], list[Guess], tuple[list[str], list[str]]]:
    """The surest guess for each channel, the others, and what is said and asked of clocks."""
    clock, said, asked = clock_of([each for each in found if each.channel == "time"], columns)
    chosen: dict[str, Guess] = {} if clock is None else {"time": clock}
    doubtful: list[Guess] = []
    for guess in sorted(found, key=lambda each: not each.sure):
        if guess.channel not in chosen:
            chosen[guess.channel] = guess
        elif guess.channel != "time" and chosen[guess.channel].sure == guess.sure:
            doubtful.append(guess)
    order = ["time", *(each.channel for each in found)]
    picked = {name: chosen[name] for name in dict.fromkeys(order) if name in chosen}
    return picked, doubtful, (said, asked)


def _required(plant: Plant, chosen: dict[str, Guess]) -> list[str]:
    """Channels to be asked for: those that the plant requires, and one measured at least."""
    needed = [name for name in plant.required if name != "time"]
    if not set(plant.judged) & chosen.keys():
        needed.append(plant.judged[0])
    return list(dict.fromkeys(needed))


def _left(mapping: Path) -> list[str]:
    """Lines of an edited mapping that are still to be filled in."""
    lines = read_text(mapping).splitlines()
    return [
        f"line {number}: {line.split('#')[0].strip()}"
        for number, line in enumerate(lines, start=1)
        if f'"{FILL_IN}"' in line.split("#")[0]
    ]


def _converted(begun: Begun, paths: Sequence[Path], mapping: Path, plant: str) -> None:
    """Convert, group, write recordings and campaign."""
    converted = convert(paths, mapping)
    begun.recordings = write_recordings(converted, begun.out / RECORDINGS)
    begun.conditions = conditions(begun.recordings, [each.recording for each in converted])
    begun.seen.append(
        f"{counted(len(converted), 'run')} under {counted(len(begun.conditions), 'command')}"
    )
    campaign = begun.out / CAMPAIGN
    if not campaign.exists():
        atomic_files.write_text(campaign, campaign_text(begun.conditions, converted, plant))


def counted(count: int, noun: str) -> str:
    """A number with its noun."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def campaign_text(found: Sequence[Condition], converted: Sequence[Converted], plant: str) -> str:
    """A campaign of all conditions, commented, to be edited."""
    lines = [
        "# Recordings by the command under which they were made. Made by `hannes begin`: edit it.",
        "# All keys: docs/reference/campaign.md",
        f'plant = "{plant}"',
        'out = "results"',
    ]
    for condition in found:
        lines.append(f"\n# {counted(len(condition.files), 'run')}, grouped by {condition.why}")
        for file in condition.files:
            lines += ["[[recording]]", f'file = "{RECORDINGS}/{file.name}"']
            lines.append(f'condition = "{condition.name}"')
            if plant == "hand" and not converted[0].recording.experiment:
                lines.append('# experiment = "void-closure"  # what was done; `hannes experiments`')
    few = [each.name for each in found if len(each.files) < 3]
    if few:
        lines.insert(2, f"# Fewer than three repeats of: {', '.join(few)}. Repeats help most.")
    return "\n".join(lines) + "\n"
