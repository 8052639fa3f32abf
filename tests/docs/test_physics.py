"""The page of physics names every parameter of the hand, and no other."""

import re

from pages import ROOT, text

from hannes.simulation.catalogue import laws
from hannes.simulation.hand.hand import Hand

PAGE = text(ROOT / "docs" / "explanation" / "physics.md")


def one_of_a_kind(name):
    """The index finger stands for all, MCP for both joints of a finger."""
    part, _, rest = name.partition(".")
    if part in ("middle", "ring", "little", "thumb"):
        part = "index"
    return f"{'mcp' if part == 'pip' else part}.{rest}"


def test_every_parameter_of_the_hand_is_named():
    named = set(re.findall(r"`([a-z_]+\.[a-z_]+)`", PAGE))
    declared = Hand().parameters.declared
    known = set(declared)
    alone = {name for name, each in declared.items() if not each.shared}
    assert {one_of_a_kind(each) for each in alone} <= {one_of_a_kind(each) for each in named}
    files = {each for each in named if each.endswith((".py", ".json"))}
    own = {each.full_name(p.name) for each in laws().values() for p in each.parameters}
    assert named - files <= known | own
