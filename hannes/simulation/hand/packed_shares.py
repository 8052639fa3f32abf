"""Where joints' own shares act in the packed vector of a hand's values."""

from hannes.simulation.hand.joint_shares import BY_TABLE
from hannes.simulation.hand.variables import PACKED, TABLES

# Place in PACKED -> name of the share that its value is multiplied by. Lanes beyond the last joint
# hold what the last joint has.
SHARES: dict[int, str] = {}
_place = len(PACKED) - sum(map(len, TABLES.values()))
for _name, _entries in TABLES.items():
    _own = BY_TABLE.get(_name, ())
    for _number in range(len(_entries)):
        if _own:
            SHARES[_place] = _own[min(_number, len(_own) - 1)]
        _place += 1
