"""Which effects of the catalogue leave alike signatures, in both protocols.

What ships of it: hannes/identification/confusability.toml.

python -m benchmarks.confusability

A signature is the derivative of a campaign's bin means by the size of an effect, at off. What the
hand's own parameters can do, each known to 2 %, is projected out. A cosine of 1 is the same
signature. An effect with a free shape counts at the shape that this campaign sees best. One
campaign of the shipped hand is made by the independent model for each protocol. It takes some three
minutes.
"""

import argparse
import tempfile
from pathlib import Path

import tomli_w

from benchmarks.truth.campaign import Spread, make
from benchmarks.truth.protocol import PROTOCOLS
from hannes.campaigns.campaign_file import read_campaign
from hannes.core.io.atomic_files import write_text
from hannes.identification.confusability import FILE
from hannes.identification.diagnosis.baseline import FINE
from hannes.identification.diagnosis.campaign_diagnosis import candidates
from hannes.identification.diagnosis.linearisation import Linearisation, first
from hannes.identification.diagnosis.parameter_space import ParameterSpace
from hannes.identification.diagnosis.repeat_groups import grouped
from hannes.identification.diagnosis.score_test import cosine_similarity, screened
from hannes.identification.diagnosis.settings import read_settings
from hannes.identification.diagnosis.simulator import Model

SEED = 4_000_000  # no study has it
PROTOCOL_NAMES = {
    "poor": "six free closures, six on the dynamometer",
    "rich": "sixteen runs, duty logged",
}
LEAST = 0.3  # cosine from which on a pair is written down


def at_given(protocol: str) -> Linearisation:
    """The shipped hand in a campaign of a protocol, with the whole catalogue on trial."""
    with tempfile.TemporaryDirectory() as folder:
        exactly = Spread(0.0, "normal", 0.0, 0.0)
        make(protocol, SEED, spread=exactly, assumed=Spread()).write(Path(folder))
        campaign = read_campaign(Path(folder) / "campaign.toml")
    usable = [effect for effect, why in candidates(campaign).values() if not why]
    groups = grouped(campaign.plant, campaign.of("fit", "select"))
    settings = read_settings(campaign.diagnose, campaign.plant)
    space = ParameterSpace(campaign.plant, groups, settings, usable)
    return first(Model(campaign.plant, groups, space, usable), FINE, 0)


def cosines(point: Linearisation) -> dict[str, dict[str, float]]:
    """Effect -> others from LEAST on, the most similar first."""
    signatures = {
        each.effect: each.signature for each in screened(point, list(point.space.effects))
    }
    found: dict[str, dict[str, float]] = {}
    for one in sorted(signatures):
        near = {
            other: cosine_similarity(point, signatures[one], signatures[other])
            for other in signatures
            if other != one
        }
        order = sorted(near, key=lambda other: -near[other])
        found[one] = {other: round(near[other], 3) for other in order if near[other] >= LEAST}
    return found


def main() -> None:
    """Measure and write."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.confusability",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--out", type=Path, default=FILE)
    out = parser.parse_args().out
    tables = {PROTOCOL_NAMES[name]: cosines(at_given(name)) for name in PROTOCOLS}
    write_text(out, "# Made by python -m benchmarks.confusability\n" + tomli_w.dumps(tables))


if __name__ == "__main__":
    main()
