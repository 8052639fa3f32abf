"""`hannes check`: finds what may be wrong with a recording, before anything is fitted to it."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from hannes.campaigns.quality import (
    breaks,
    clock,
    command,
    crosstalk,
    disabled,
    held,
    jumps,
    lost,
    magnitudes,
    motion,
    sensors,
    winding,
)
from hannes.campaigns.quality.finding import LEVELS, Finding, note
from hannes.campaigns.quality.one_line import one_line_each
from hannes.campaigns.quality.subject import Plan, Subject
from hannes.campaigns.undeclared import undeclared, without
from hannes.core.errors import BadInput
from hannes.core.recording.recording import SUFFIXES, Recording
from hannes.plants.protocol import (
    PLANTS,
    Plant,
    commanded,
    expectations,
    find_plant,
    shipped_plant,
)
from hannes.simulation.experiment.reader import experiment_text, parse_experiment

CALM = ("gap", "coarse")  # kinds of finding beside which a law of the drive still holds


def check(recording: Recording, plant: Plant | None = None) -> list[Finding]:
    """Return all data-quality issues of one recording, faults first.

    What a plant expects of its channels (`Plant.expected`) sharpens the checks. Without a plant
    only what holds for any machine is checked. Nothing is simulated, nothing raised. A fault
    says that the recording would mislead a fit, and what to do about it.
    """
    expected = dict(expectations(plant)) if plant is not None else {}
    asked = commanded(plant) if plant is not None else frozenset()
    block = plant.block if plant is not None else 0.0
    others = undeclared(recording, plant) if plant is not None else ()
    recording = without(recording, others)
    needed = frozenset(plant.required) if plant is not None else frozenset()
    motor = winding.winding_of(plant) if plant is not None else None
    subject = Subject(recording, expected, block, asked, _plan(recording), needed, motor)
    found = sorted(_found(subject), key=lambda each: LEVELS.index(each.level))
    unused = "is no channel of this plant, and is left out"
    return [*one_line_each(found, subject), *(note("other", name, unused) for name in others)]


def _found(subject: Subject) -> Iterator[Finding]:
    found = [*_single(subject)]
    yield from found
    calm = all(each.level == "note" or each.kind in CALM for each in found)
    broken = [*disabled.stood(subject), *breaks.inspect(subject)][:1] if calm else []
    yield from broken
    if not broken and all(each.level != "fault" and each.kind != "drift" for each in found):
        yield from command.retimed(subject)


def _single(subject: Subject) -> Iterator[Finding]:
    """What is looked for whatever else is found."""
    yield from clock.inspect(subject)
    yield from crosstalk.inspect(subject)
    yield from held.inspect(subject)
    yield from lost.inspect(subject)
    yield from jumps.inspect(subject)
    yield from disabled.inspect(subject)
    yield from sensors.inspect(subject)
    yield from magnitudes.inspect(subject)
    yield from winding.inspect(subject)
    yield from motion.inspect(subject)
    if subject.plan is not None:
        yield from command.inspect(subject, subject.plan)


def _plan(recording: Recording) -> Plan | None:
    """The command of the experiment that a recording carries, None where it carries none."""
    if not recording.experiment:
        return None
    try:
        experiment = parse_experiment(recording.experiment)
    except BadInput:  # of another plant
        return None
    times, values = experiment.reference.knots
    return Plan(times, values, experiment.object is not None)


def subjects(
    path: str | Path,
    plant: str | None = None,
    experiment: str | None = None,
    *,
    mapping: str | Path | None = None,
    trust: bool = False,
) -> list[tuple[str, Recording, Plant]]:
    """Names, recordings and plants of a recording's file, or of a campaign (TOML, shipped name).

    `plant` and `experiment` are names, for a recording that does not carry them itself; a plant of
    the user's own is looked for in the current folder. `mapping`: through which the file, a raw
    log, is read. `trust`: Python that a campaign or mapping names may run. Raises BadInput for what
    cannot be read.
    """
    from hannes.campaigns.campaign_file import read_campaign, read_runs

    if Path(path).suffix in (".toml", ""):
        if plant or experiment or mapping:
            raise BadInput(
                f"{path}: a campaign names plant, experiments and mappings itself: leave them out"
            )
        campaign = read_campaign(path, trust=trust)
        return [(each.name, each.recording, campaign.plant) for each in campaign.entries]
    if mapping is not None:
        found, runs = _mapped(Path(path), plant, mapping, trust)
    elif plant:
        found = find_plant(plant)
        runs = read_runs(Path(path), found)
    else:
        found, runs = _without_plant(Path(path))
    if experiment is not None:
        text = experiment_text(experiment)
        if found.name == "hand":  # whose experiments these are
            parse_experiment(text, experiment)
        runs = {name: replace(each, experiment=text) for name, each in runs.items()}
    for each in runs.values():
        _expect(each, found, path)
    return [(name if len(runs) > 1 else str(path), each, found) for name, each in runs.items()]


def _mapped(
    path: Path, plant: str | None, mapping: str | Path, trust: bool
) -> tuple[Plant, dict[str, Recording]]:
    """Plant and runs of a raw log by a mapping."""
    from hannes.campaigns.foreign.mapping_file import read_mapping
    from hannes.campaigns.mapped_runs import mapped_runs

    if plant:
        raise BadInput(f"{path}: the mapping names the plant: leave --plant out")
    rules = read_mapping(mapping, trust=trust)
    return rules.plant, mapped_runs(path, rules)


def _without_plant(path: Path) -> tuple[Plant, dict[str, Recording]]:
    """A recording and the plant that it names."""
    if not path.name.lower().endswith(SUFFIXES):
        expected = ", ".join(SUFFIXES)
        raise BadInput(
            f"{path}: expected a recording named {expected}; a raw log needs --mapping, which "
            f"`hannes begin {path.name}` writes"
        )
    recording = Recording.read(path)
    return _named_by(recording, path), {"": recording}


def _named_by(recording: Recording, path: Path) -> Plant:
    """The plant that a recording names: data chooses only among those that ship."""
    if recording.plant and recording.plant not in PLANTS:
        raise BadInput(
            f'{path}: a recording of the plant "{recording.plant:.60}", which does not ship with '
            "hannes: name its Python with --plant file.py:NAME"
        )
    return shipped_plant(recording.plant or "hand")


def _expect(recording: Recording, plant: Plant, path: str | Path) -> None:
    try:
        known = without(recording, undeclared(recording, plant))
        known.expect(plant.channels, what=f"the plant {plant.name}")
    except BadInput as error:
        raise BadInput(f"{path}: {error}; name another plant with --plant") from None


def refuse_faults(named: Iterable[tuple[str, Sequence[Finding]]]) -> None:
    """Raise BadInput with the first fault and their number; `named` are files and findings."""
    faults = [(name, each) for name, found in named for each in found if each.level == "fault"]
    if faults:
        name, first = faults[0]
        more = f" ({len(faults) - 1} more faults: see `hannes check`)" if len(faults) > 1 else ""
        raise BadInput(f"{name}: {first}{more}")
