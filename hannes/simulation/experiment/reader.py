"""An experiment's TOML into an `Experiment`: what is done with the hand, whichever hand it is."""

from pathlib import Path

import numpy as np

from hannes.contact.shapes import SHAPES
from hannes.core.errors import BadInput
from hannes.core.io.toml_table import Table, parsed, read_text
from hannes.core.io.units import quantity
from hannes.simulation.experiment import shipped
from hannes.simulation.experiment.experiment import CONTROLLERS, Experiment, Reference, Target
from hannes.simulation.hand import variables
from hannes.simulation.hand.hand_file import checked

COMMON = ("title", "kind", "hand", "effects", "parameters")
TABLES = ("reference", "object", "noise", "sweep", "scatter")
KEYS = (*COMMON, "duration", "sampling", "controller", *TABLES)
REFERENCE = ("kind", "points", "path")
OBJECT = ("shape", "radius", "size", "position", "turn", "tilt", "material", "sensor")
MATERIAL = ("stiffness", "damping", "friction", "slip_speed", "onset")
SIZE = ("width", "height", "rounding")
NOISE = {"position": "rad", "current": "A", "duty": "1", "supply": "V", "force": "N", "sensor": "N"}
LOUDEST = {"rad": 10.0, "A": 100.0, "1": 10.0, "V": 100.0, "N": 1000.0}  # noise of any sensor
FARTHEST = 1000.0  # rad, of a reference at the output shaft: the hand closes within ten
ROUNDING = 3e-3  # m, of a prism's edges where the file gives none
MOST_SAMPLES = 1_000_000
LARGEST_SEED = 2**63 - 1

_DECLARED = {each.name: each for each in variables.PARAMETERS}


def parse_experiment(
    text: str, where: str = "experiment", folder: Path | None = None
) -> Experiment:
    """Return what was done with the hand, from TOML text; which hand it was is not read.

    This is for the experiment text of a recording: sweep and scatter are refused.
    """
    root = Table.parse(text, where, KEYS)
    if folder is None and "path" in root.table("reference"):
        root.refuse("reference.path", "names a file: a recording's own text has points instead")
    for key in ("sweep", "scatter"):
        if key in root:
            root.refuse(key, "stands for several experiments; expected one")
    return read_experiment(root, folder)


def experiment_text(name: str, folder: Path | None = None) -> str:
    """Return the TOML text of an experiment: a shipped name, or a .toml relative to `folder`.

    It needs no other file: a recorded reference stands in it point by point.
    """
    path = (folder or Path()) / shipped.find(name)
    text = read_text(path)
    reference = Table.parse(text, str(path), KEYS).table("reference", REFERENCE)
    if reference.content.get("kind") != "file" or "path" not in reference or "points" in reference:
        return text
    return _with_points(text, _recorded(reference, path.parent))


def _with_points(text: str, reference: Reference) -> str:
    import tomli_w

    content = parsed(text)
    points = [[f"{time!r} s", f"{angle!r} rad"] for time, angle in reference.knots.T.tolist()]
    content["reference"] = {"kind": "file", "points": points}
    return tomli_w.dumps(content)


def read_experiment(root: Table, folder: Path | None) -> Experiment:
    """Return what the tables ask for; relative paths start at `folder`; BadInput otherwise."""
    reference, noise = read_reference(root, folder), root.table("noise", (*NOISE, "seed"))
    return Experiment(
        root.text("title", Path(root.where).stem),
        _duration(root, reference),
        reference,
        read_object(root),
        _sampling(root, reference),
        root.choice("controller", CONTROLLERS, "continuous"),
        _surroundings(root),
        noise=_noise(noise),
        seed=noise.whole("seed", 0, LARGEST_SEED, 0),
    )


def _surroundings(root: Table) -> dict[str, float]:
    """Values of `[parameters]` that belong to the experiment, whichever hand makes it."""
    table = root.table("parameters")
    return {
        name: checked(given, _DECLARED[name], table)
        for name, given in table.content.items()
        if name in _DECLARED and name.startswith(("gravity.", "object."))
    }


def _duration(root: Table, reference: Reference) -> float:
    """Return the time simulated [s]; a recorded reference gives its own."""
    if "duration" not in root and not reference.kinked:
        return float(reference.knots[0, -1])
    duration = root.quantity("duration", "s", "1.15 s")
    if not 0.0 < duration <= 3600.0:
        root.refuse("duration", f"= {duration:g} s: expected more than 0 and at most 3600 s")
    return duration


def _sampling(root: Table, reference: Reference) -> float:
    sampling = root.quantity("sampling", "Hz", "1 kHz") if "sampling" in root else 1000.0
    if not 0.0 < sampling <= MOST_SAMPLES / _duration(root, reference):
        root.refuse(
            "sampling",
            f"= {sampling:g} Hz: expected more than 0 Hz and at most {MOST_SAMPLES} samples in all",
        )
    return sampling


def read_reference(root: Table, folder: Path | None, key: str = "reference") -> Reference:
    """Return the position reference: a ramp through points, steps, or a recorded one."""
    root.require(key, '{ kind = "ramp", points = [["0 s", "0 rad"], ["1 s", "5 rad"]] }')
    table = root.table(key, REFERENCE)
    kind = table.choice("kind", ("ramp", "steps", "file"))
    if kind == "file" and ("path" in table) == ("points" in table):
        table.refuse("path", "or points: a recorded reference needs one of the two")
    if kind != "file" and "path" in table:
        table.refuse("path", f'belongs to kind = "file", not to kind = "{kind}"')
    if "path" in table:
        return _recorded(table, folder)
    try:
        knots = _points(table)
        return Reference(_stairs(knots) if kind == "steps" else knots, kinked=kind != "file")
    except BadInput as error:
        if str(error).startswith(table.where):
            raise
        table.refuse("points", f"cannot be used: {error}")


def _points(table: Table) -> np.ndarray:
    """Return knots, shape (2, n), from a list of ["time", "angle"] pairs."""
    table.require("points", '[["0 s", "0 rad"], ["0.6 s", "9.8 rad"]]')
    pairs = [
        Table({f"points[{k}]": pair}, table.where, (), table.prefix).items(f"points[{k}]", 2)
        for k, pair in enumerate(table.items("points"))
    ]
    rows = [
        (
            quantity(time, "s", table.name(f"points[{k}]")),
            quantity(angle, "rad", table.name(f"points[{k}]")),
        )
        for k, (time, angle) in enumerate(pairs)
    ]
    for k, (_, angle) in enumerate(rows):
        if abs(angle) > FARTHEST:
            table.refuse(f"points[{k}]", f"= {angle:g} rad: expected within {FARTHEST:g} rad")
    return np.array(rows, float).reshape(-1, 2).T


def _stairs(points: np.ndarray) -> np.ndarray:
    """Return knots that hold each angle until the next time."""
    times, angles = np.repeat(points[0], 2)[1:], np.repeat(points[1], 2)[:-1]
    end = points[:, -1:] + np.array([[1.0], [0.0]])
    return np.hstack([[times, angles], end])


def _recorded(table: Table, folder: Path | None) -> Reference:
    """Return the reference channel of a recording, its time from zero."""
    from hannes.core.recording.recording import Recording

    path = (folder or Path()) / table.text("path", "")
    try:
        recording = Recording.read(path)
        recording.expect({**recording.units, "reference": "rad"}, ("reference",))
    except BadInput as error:
        table.refuse("path", f"cannot be used: {error}")
    return Reference(np.array([recording.time - recording.time[0], recording["reference"]]), False)


def read_object(root: Table) -> Target | None:
    """Return the object to grasp, None where there is none; only values the file gives."""
    if "object" not in root:
        return None
    table = root.table("object", OBJECT)
    shape = table.choice("shape", tuple(SHAPES))
    values = _size(table) if shape == "prism" else _radius(table, shape)
    material = table.table("material", MATERIAL)
    for key in material.content:
        values[f"object.{key}"] = _value(material, key, f"object.{key}")
    if "position" in table:
        values |= _placed(table, "position", ("x", "y", "z"))
    if "tilt" in table:
        values |= _placed(table, "tilt", ("tilt_x", "tilt_y"))
    if "turn" in table:
        values["object.turn"] = _value(table, "turn", "object.turn")
    _refuse_twice(root, values)
    return Target(shape, values, table.flag("sensor"))


def _value(table: Table, key: str, parameter: str, share: float = 1.0) -> float:
    """Return `share` of a key's value, checked against the parameter it becomes."""
    declared = _DECLARED[parameter]
    number = share * table.quantity(key, declared.unit)
    try:
        return declared.check(number)
    except BadInput as error:
        table.refuse(key, f"is out of bounds: {error}")


def _radius(table: Table, shape: str) -> dict[str, float]:
    if "size" in table:
        table.refuse("size", f'belongs to shape = "prism"; a {shape} has a radius')
    return {"object.radius": _value(table, "radius", "object.radius")} if "radius" in table else {}


def _size(table: Table) -> dict[str, float]:
    if "radius" in table:
        table.refuse(
            "radius", "does not belong to a prism: it has size = { width, height, rounding }"
        )
    table.require("size", '{ width = "40 mm", height = "30 mm", rounding = "3 mm" }')
    size = table.table("size", SIZE)
    size.require("width", '"40 mm"')
    size.require("height", '"30 mm"')
    half_x = _value(size, "width", "object.half_x", 0.5)
    half_y = _value(size, "height", "object.half_y", 0.5)
    usual = min(ROUNDING, half_x, half_y)
    rounding = _value(size, "rounding", "object.radius") if "rounding" in size else usual
    if "rounding" in size and rounding > min(half_x, half_y):
        size.refuse("rounding", "is more than half of the smaller side; make it smaller")
    return {"object.half_x": half_x, "object.half_y": half_y, "object.radius": rounding}


def _placed(table: Table, key: str, names: tuple[str, ...]) -> dict[str, float]:
    """Values of a list in the file, one for each of the object's parameters `names`."""
    return {
        f"object.{name}": checked(given, _DECLARED[f"object.{name}"], table)
        for name, given in zip(names, table.items(key, len(names)), strict=True)
    }


def _refuse_twice(root: Table, values: dict[str, float]) -> None:
    given = root.table("parameters").content
    for name in values:
        if name in given:
            root.refuse(f'parameters."{name}"', "is given in [object] too; keep one of them")


def _noise(table: Table) -> dict[str, float]:
    """Return standard deviations by channel, SI."""
    found = {key: table.quantity(key, NOISE[key]) for key in table.content if key in NOISE}
    for key, spread in found.items():
        if spread > LOUDEST[NOISE[key]]:
            unit = NOISE[key]
            table.refuse(key, f"= {spread:g} {unit}: expected at most {LOUDEST[unit]:g} {unit}")
        if spread < 0.0:
            table.refuse(key, f"= {spread:g}: a standard deviation is not negative")
    return found
