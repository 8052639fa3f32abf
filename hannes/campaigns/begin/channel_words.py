"""Words by which columns are recognised: English, German, French, Italian and Spanish.

Accents are left out here, and before a name is compared.
"""

import re
import unicodedata
from collections.abc import Sequence

WORDS = {
    "time": (
        "time", "t", "timestamp", "stamp", "ts", "tstamp", "millis", "micros", "clock", "x_value",
        "realtime", "elapsed", "epoch", "utc", "datetime", "tick", "ticks",
        "zeit", "zeitstempel", "uhrzeit", "temps", "horodatage", "tempo", "tiempo",
    ),
    "reference": (
        "reference", "ref", "goal", "target", "tgt", "setpoint", "set", "command", "cmd", "desired",
        "des", "commanded", "action", "sp",
        "soll", "sollwert", "fuhrungsgrosse", "vorgabe", "ziel", "zielwert",
        "consigne", "cible", "commande", "riferimento", "comando",
        "referencia", "consigna", "objetivo",
    ),
    "position": (
        "position", "pos", "angle", "encoder", "enc", "theta", "q", "shaft", "measured", "present",
        "joint", "state",
        "ist", "istwert", "lage", "stellung", "winkel", "weg", "mesure", "deplacement",
        "posizione", "angolo", "misurato", "spostamento",
        "posicion", "angulo", "medido", "desplazamiento",
    ),
    "current": (
        "current", "cur", "curr", "amps", "i", "motor_current", "amp", "iq",
        "ibus", "ibat", "ibatt", "isupply", "idc", "ipsu", "iin",
        "strom", "courant", "intensite", "corrente", "corriente", "intensidad",
    ),
    "duty": ("duty", "pwm", "dutycycle", "tastgrad", "tastverhaltnis"),
    "supply": (
        "supply", "vbus", "voltage", "battery", "vbat", "vin", "volt", "bus",
        "spannung", "batterie", "tension", "tensione", "batteria", "voltaje", "bateria",
    ),
    "force": ("force", "grip", "kraft", "forza", "fuerza"),
    "sensor": (
        "sensor", "dynamometer", "dyno", "loadcell", "cell", "kraftmessdose", "kraftsensor",
        "dynamometre", "dinamometro",
    ),
}  # fmt: skip
WEAK = (
    "present", "measured", "state", "joint", "set", "bus", "motor", "cell", "actual",
    "ist", "istwert", "mesure", "misurato", "medido",
)  # fmt: skip
# With which words of one piece end: Motorstrom, Istwinkel.
HEADS = (
    "time", "position", "angle", "current", "voltage", "force", "setpoint",
    "zeit", "sollwert", "istwert", "winkel", "strom", "spannung", "kraft",
)  # fmt: skip
# Quantities that are no channel of any plant, though their names may have a word of one.
OTHERS = (
    "velocity", "vel", "speed", "acceleration", "accel", "torque", "error", "temperature",
    "geschwindigkeit", "drehzahl", "beschleunigung", "moment", "drehmoment", "fehler", "temperatur",
    "vitesse", "couple", "erreur", "velocita", "coppia", "errore", "velocidad", "par",
)  # fmt: skip
# Of a current that is drawn from the supply, as whole words, and as beginnings of others.
OF_SUPPLY = (
    "supply", "bus", "vbus", "battery", "bat", "batt", "vbat", "pack", "dc", "input", "psu",
    "mains", "ibus", "ibat", "ibatt", "isupply", "idc", "ipsu", "iin", "batteria",
    "bateria", "batterie", "alimentation", "alimentazione", "alimentacion", "akku", "netzteil",
)  # fmt: skip
OF_SUPPLY_STARTS = ("versorgung", "batterie", "zwischenkreis", "netzteil", "akku", "busstrom")
# Words of it that may as well be of a motor (a DC motor, its input): asked about.
PERHAPS_OF_SUPPLY = ("dc", "input")
MEASURED = ("current", "supply", "force", "sensor")  # never a command


def plain(text: str) -> str:
    """A text in lower case without accents."""
    apart = unicodedata.normalize("NFKD", text.lower().replace("ß", "ss"))
    return "".join(each for each in apart if not unicodedata.combining(each))


def scores(words: Sequence[str], channels: Sequence[str]) -> dict[str, float]:
    """How well the words of a column's name speak for each channel, 0 for not at all.

    A command of what is only ever measured (a wanted current), and quantities that no channel
    has, speak for none.
    """
    found = {
        channel: sum(_likeness(word, WORDS.get(channel, (channel,))) for word in words)
        for channel in channels
    }
    if "_".join(words) in WORDS["time"]:
        found["time"] = 1.0
    wanted = found.get("reference", 0.0) > 0.0 and any(found.get(c, 0.0) > 0.0 for c in MEASURED)
    if wanted or set(words) & set(OTHERS):
        return dict.fromkeys(found, 0.0)
    return found


def from_supply(words: Sequence[str]) -> bool:
    """Whether the words of a current's name say that it was measured at the supply."""
    if set(words) & {"motor", "phase", "winding"}:
        return False
    return any(word in OF_SUPPLY or word.startswith(OF_SUPPLY_STARTS) for word in words)


def surely_from_supply(words: Sequence[str]) -> bool:
    """Whether a current is of the supply by a word that has no other meaning."""
    return from_supply([word for word in words if word not in PERHAPS_OF_SUPPLY])


def _likeness(word: str, spellings: Sequence[str]) -> float:
    """1 where a word is one of the spellings (0.3 of a weak one), a half where it has one."""
    if word in spellings:
        return 0.3 if word in WEAK else 1.0
    begins = any(len(each) > 3 and word.startswith(each) for each in spellings)
    return 0.5 * (begins or any(each in HEADS and word.endswith(each) for each in spellings))


def words_of(name: str) -> list[str]:
    """Words of a name as they are spelled; `I_mA` ends with milliamperes, not with amperes."""
    found: list[str] = []
    for piece in re.split(r"[^\w°%]+|_", name):
        unit = re.fullmatch(r"(.*?)([mk][AVN]|mrad)", piece)
        start = unit[1] if unit else piece
        apart = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", start).split()
        found += [*apart, unit[2]] if unit else apart
    return found
