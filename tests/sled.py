"""A sled on a rail, pushed by a known force: a machine small enough to know all of it.

Its effects are a user's own. `campaign` makes recordings in which some are hidden.
"""

import functools
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np

from hannes.campaigns.campaign import Campaign, Entry
from hannes.commands.diagnose import diagnose
from hannes.core.description import Description, coefficients
from hannes.core.effect import Effect, Term
from hannes.core.io.toml_table import Table
from hannes.core.kernels.jit import kernel
from hannes.core.kernels.series import legendre, placed
from hannes.core.parameter import Parameter
from hannes.core.recording.recording import Recording
from hannes.identification.diagnosis.effect_search import search_effects
from hannes.identification.diagnosis.settings import Settings
from hannes.plants.plain import PlainPlant

STEP, TIMES = 2e-3, np.arange(500) * 2e-3
UNITS = {"time": "s", "drive": "N", "position": "m", "speed": "m/s"}
ROLES = ("fit", "fit", "select", "show")
RAIL = 0.4  # m, on either side of its middle
RATTLE = "rattled"  # a run that separates turbulence from friction at low speed


class Sled(PlainPlant):
    """A driven mass on a spring with drag; hard driven or hardly at all."""

    def proposals(self, recorded):
        assert set(recorded) == {"slow", "fast"}
        bare = {n: np.zeros(TIMES.size) for n in UNITS} | {"time": TIMES}
        drives = {"idle": 0.01 * np.sin(4.0 * TIMES), RATTLE: 60.0 * np.sin(9.0 * TIMES)}
        return {name: Recording(bare | {"drive": drive}, UNITS) for name, drive in drives.items()}

    name = "sled"
    channels = UNITS
    required = ("drive",)
    judged = ("position", "speed")
    base = (
        Parameter("sled.mass", 1.0, "kg", (0.1, 10.0), "of the sled"),
        Parameter("sled.drag", 2.0, "N s/m", (0.0, 20.0), "against the rail"),
        Parameter("spring.stiffness", 40.0, "N/m", (1.0, 400.0), "pulls it back"),
    )
    free: ClassVar = {"sled.mass": 0.03, "sled.drag": 0.06, "spring.stiffness": 1.2}
    uncertain: ClassVar = {"sled.mass": 1.0, "sled.drag": 2.0, "spring.stiffness": 40.0}
    run_to_run: ClassVar = {"sled.drag": 0.02}
    block = 0.2
    open: ClassVar = {"force": ("speed", "position", "time")}

    def simulate(self, parameters, recording):
        p = self.parameters.with_values(parameters)
        mass, drag, stiffness = (p[each.name] for each in self.base)
        more, x, v = self.added("force", parameters), 0.0, 0.0
        position, speed = np.zeros(TIMES.size), np.zeros(TIMES.size)
        for k, (time, drive) in enumerate(
            zip(TIMES.tolist(), recording["drive"].tolist(), strict=True)
        ):
            position[k], speed[k] = x, v
            v += STEP * (drive - drag * v - stiffness * x + more(v, x, time)) / mass
            x += STEP * v
        return {"position": position, "speed": speed}


@kernel
def hardening(size, position):
    """Of the spring [N]."""
    return -size * position**3


@kernel
def stiffer(size, position):
    """Of the spring, as its stiffness is [N]."""
    return -size * position


@kernel
def turbulence(size, speed):
    """Quadratic drag [N]."""
    return -size * speed * abs(speed)


@kernel
def suction(size, speed):
    """Quadratic drag, marked by a size below 0 [N]."""
    return size * speed * abs(speed)


@kernel
def nearly_turbulence(size, speed):
    """Quadratic drag until it is fast [N]."""
    return -size * speed * min(abs(speed), 2.255)


@kernel
def gust(size, time):
    """What no effect below is [N]."""
    return size * np.sin(23.0 * time)


@kernel
def washboard(size, count, position):
    """A rail with so many waves in a metre [N]."""
    return size * np.sin(2.0 * np.pi * count * position)


def effect(name, function, largest, unit):
    """An effect of one amplitude, from 0."""
    size = Parameter("size", 0.0, unit, (0.0, largest), "how much", off=0.0)
    return Effect(
        name, "made for a test", "F += ...", "none (2026)", (size,), (Term(function, ("force",)),)
    )


HARDENING = effect("hardening", hardening, 6000.0, "N/m^3")
STIFFER = effect("stiffer", stiffer, 40.0, "N/m")
TURBULENCE = effect("turbulence", turbulence, 30.0, "N s^2/m^2")
NARROW = effect("turbulence", turbulence, 1.0, "N s^2/m^2")  # of less than is hidden
TWIN = effect("twin", turbulence, 30.0, "N s^2/m^2")
WAVES = Effect(
    "washboard", "made for a test", "F += size sin(2 pi count x)", "none (2026)",
    (
        Parameter("size", 0.0, "N", (0.0, 5.0), "how much", off=0.0),
        Parameter("count", 5.0, "1/m", (1.0, 60.0), "waves", tried=tuple(map(float, range(1, 40)))),
    ),
    (Term(washboard, ("force",)),),
)  # fmt: skip
WAVES_OF_23 = replace(
    WAVES, parameters=(WAVES.parameters[0], replace(WAVES.parameters[1], value=23.0))
)
GUST = effect("gust", gust, 5.0, "N")
KNOWN = {each.name: each for each in (HARDENING, TURBULENCE)}


@kernel
def anywhere(place, c_0, c_1, c_2, c_3, c_4):
    """Force over the place on the rail [N]."""
    return legendre(placed(place, -RAIL, RAIL), c_0, c_1, c_2, c_3, c_4)


@kernel
def force(position, c_0, c_1, c_2, c_3, c_4):
    """On the sled [N]."""
    return anywhere(position, c_0, c_1, c_2, c_3, c_4)


PLACED = Description(
    Effect(
        "generic_force", "A force depends on the place.", "F += sum c_k P_k(x)", "Legendre",
        coefficients("N", 20.0), (Term(force, ("force",)),),
    ),
    "the place on the rail", "m", (-RAIL, RAIL), "a force", "N", anywhere,
)  # fmt: skip


class Described(Sled):
    """A sled that knows a generic disturbance of its own."""

    generic: ClassVar = {"generic_force": PLACED}


def drives():
    """Two commands, each recorded four times."""
    return {
        "slow": 6.0 * np.sin(4.0 * TIMES),
        "fast": 12.0 * np.sign(np.sin(9.0 * TIMES)) * (TIMES < 0.8),
    }


@functools.cache
def recordings(seed, hidden=(), growth=0.0):
    """Entries of a scattered sled with hidden effects of given sizes, sensors noisy.

    growth: of the effects with every run, as a share of their size
    """
    rng = np.random.default_rng(seed)
    sled = Sled().with_effects(*(each for each, _ in hidden))
    machine = {
        name: sled.parameters[name] * (1.0 + 0.02 * rng.standard_normal())
        for name in Sled.uncertain
    }
    machine |= {each.full_name("size"): size for each, size in hidden}
    made = []
    for condition, drive in drives().items():
        for number, role in enumerate(ROLES):
            bare = Recording(
                {"time": TIMES, "drive": drive}, {n: UNITS[n] for n in ("time", "drive")}
            )
            own = {
                **machine,
                "sled.drag": machine["sled.drag"] * (1.0 + 0.005 * rng.standard_normal()),
            }
            for each, size in hidden:
                own[each.full_name("size")] = size * (1.0 + growth * len(made))
            run = sled.simulate(own, bare)
            noisy = {
                name: values + 2e-3 * rng.standard_normal(TIMES.size)
                for name, values in run.items()
            }
            recording = Recording({"time": TIMES, "drive": drive, **noisy}, UNITS)
            made.append(Entry(f"{condition}_{number}", recording, condition, role, len(made)))
    return tuple(made)


def campaign(seed, hidden=(), known=KNOWN, growth=0.0):
    """A campaign of these, with what the bench says of its scatter."""
    said = Table({"scatter": "2 %", "run_scatter": "0.5 %"}, "campaign.toml", ())
    made = recordings(seed, hidden, growth)
    return Campaign(Sled(), Sled(), made, Path("out"), known, diagnose=said)


def found(seed, hidden=(), known=KNOWN, growth=0.0):
    """The verdict."""
    return diagnose(campaign(seed, hidden, known, growth), progress=False).verdict


@functools.cache
def investigation():
    """What an investigation of hidden turbulence finds."""
    entries = [e for e in recordings(1, ((TURBULENCE, 2.0),)) if e.role != "show"]
    return search_effects(Sled(), entries, list(KNOWN.values()), Settings(0.02, 0.005), 0)


THREE = ((HARDENING, 900.0), (TURBULENCE, 2.0), (GUST, 1.0))
WITH_GUST = {**KNOWN, "gust": GUST}


def three_found():
    """What a search finds of three hidden effects; anew, as tests change its bound of work."""
    entries = [e for e in recordings(3, THREE) if e.role != "show"]
    return search_effects(Sled(), entries, list(WITH_GUST.values()), Settings(0.02, 0.005), 0)
