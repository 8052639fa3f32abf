"""`hannes check`: what may be wrong with a recording, before anything is fitted to it."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from hannes.errors import BadInput
from hannes.experiment_file import experiment_text, parse_experiment
from hannes.findings import clock, motion, planned, sensors, sizes
from hannes.findings.finding import LEVELS, Finding
from hannes.findings.subject import Subject
from hannes.plant import Plant, expectations, find_plant
from hannes.recording import Recording


def check(recording: Recording, plant: Plant | None = None) -> list[Finding]:
    """Return everything found in one recording, faults first.

    What a plant expects of its channels (`Plant.expected`) sharpens the checks; without a plant
    only what holds for any machine is looked at. Nothing is simulated, nothing raised: a fault
    says that the recording would lead a fit astray, and what to do about it.
    """
    expected = dict(expectations(plant)) if plant is not None else {}
    subject = Subject(recording, expected, plant.block if plant is not None else 0.0)
    found = list(_found(subject))
    return sorted(found, key=lambda each: LEVELS.index(each.level))


def _found(subject: Subject) -> Iterator[Finding]:
    yield from clock.inspect(subject)
    yield from sensors.inspect(subject)
    yield from sizes.inspect(subject)
    yield from motion.inspect(subject)
    plan = _plan(subject.recording)
    if plan is not None:
        yield from planned.inspect(subject, plan)


def _plan(recording: Recording) -> planned.Plan | None:
    """The command of the experiment that a recording carries, None where it carries none."""
    if not recording.experiment:
        return None
    try:
        experiment = parse_experiment(recording.experiment)
    except BadInput:  # of another plant
        return None
    return planned.Plan(*experiment.reference.knots)


def subjects(
    path: str | Path, plant: str | None = None, experiment: str | None = None
) -> list[tuple[str, Recording, Plant]]:
    """Names, recordings and plants of a recording's file, or of a campaign (TOML, shipped name).

    `plant` and `experiment` are names, for a recording that does not tell them itself. Raises
    BadInput for what cannot be read.
    """
    from hannes.campaign import read_campaign, read_recording

    if Path(path).suffix in (".toml", ""):
        campaign = read_campaign(path)
        return [(each.name, each.recording, campaign.plant) for each in campaign.entries]
    recording = read_recording(Path(path))
    found = find_plant(plant or recording.plant or "hand", Path(path).parent)
    if experiment is not None:
        recording = replace(recording, experiment=experiment_text(experiment))
    try:
        recording.expect(found.channels, what=f"the plant {found.name}")
    except BadInput as error:
        raise BadInput(f"{path}: {error}; name another plant with --plant") from None
    return [(str(path), recording, found)]


def refuse_faults(named: Iterable[tuple[str, Sequence[Finding]]]) -> None:
    """Raise BadInput with the first fault and their number; `named` are files and findings."""
    faults = [(name, each) for name, found in named for each in found if each.level == "fault"]
    if faults:
        name, first = faults[0]
        more = f" ({len(faults) - 1} more faults: see `hannes check`)" if len(faults) > 1 else ""
        raise BadInput(f"{name}: {first}{more}")
