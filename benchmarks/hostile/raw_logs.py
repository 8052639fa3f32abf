"""Mutants of a raw log."""

import struct

from benchmarks.hostile import nasty
from benchmarks.hostile.corpus import as_json
from benchmarks.hostile.nasty import Rng


def raw_log(data: bytes, rng: Rng) -> bytes:
    """Records of a raw log changed: its first line, stamps, lengths, bytes."""
    kind = rng.random()
    if kind < 0.2:
        return nasty.octets(data, rng)
    head, _, rest = data.partition(b"\n")
    if kind < 0.5:
        return as_json(head, rng) + b"\n" + rest
    new, at, cut = bytearray(rest), 0, []
    while at + 13 <= len(rest):
        cut.append(at)
        at += 13 + struct.unpack_from("<QBI", rest, at)[2]
    for _ in range(rng.integers(1, 4)):
        place = cut[rng.integers(0, len(cut))]
        size = struct.unpack_from("<QBI", rest, place)[2]
        if rng.random() < 0.15:
            struct.pack_into("<Q", new, place, int(rng.integers(0, 2**63)))
        elif size:
            new[place + 13 + int(rng.integers(0, size))] = rng.integers(0, 256)
    return head + b"\n" + bytes(new)
