"""Raw logs of boards that print lines, send frames or are polled, and how they are changed."""

import json
import struct
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.hostile import nasty
from benchmarks.hostile.corpus import COLUMNS, COUNT, as_json
from benchmarks.hostile.models import TIMES, grasps
from benchmarks.hostile.nasty import Rng

RECORD = struct.Struct("<QBI")  # host time [ns], direction, length
SHARE = 0.2  # of mutants whose bytes are changed, whatever they mean


def log(board: str, packets: list[bytes], options: dict[str, Any]) -> bytes:
    """A raw log of what a board of this kind sent, a packet a record."""
    head = {"schema": "hannes-raw-log-1", "board": board, "options": options, "notes": ["a"]}
    found = [json.dumps(head).encode() + b"\n"]
    for k, data in enumerate(packets):
        found.append(RECORD.pack(10**7 * k, 0, len(data)) + data)
    return b"".join(found)


def of_lines() -> bytes:
    """A log of a board that prints lines."""
    lines = ["# time_us position_rad current_A"]
    lines += [f"{10000 * k} {x:.5f} 0.1" for k, x in enumerate(COLUMNS["position"])]
    return log("text", [line.encode() + b"\n" for line in lines], {})


def grasping() -> bytes:
    """A log of a board that prints lines, while a hand grasps something."""
    channels = grasps(np.array([True]))
    named = {name: channels[name][0] for name in ("reference", "position", "current")}
    rows = zip(TIMES, *named.values(), strict=True)
    lines = ["# time_s reference_rad position_rad current_A"]
    lines += [" ".join(f"{x:.5f}" for x in row) for row in rows]
    return log("text", [line.encode() + b"\n" for line in lines], {})


class Standing:
    """A machine that stands still."""

    def __init__(self) -> None:
        from hannes.bench.messages import Channel

        position = Channel(0, "position", "rad", "i", 1e-6)
        self.channels = (position, Channel(1, "current", "A", "h", 1e-3))

    def step(self, reference: float | None) -> dict[str, float]:
        """Measure the same."""
        return {"position": 1.5, "current": 0.2}


def frames() -> list[Any]:
    """What a board that speaks in frames says: who it is, samples, its state, an answer."""
    from hannes.bench.board_logic import BoardLogic
    from hannes.bench.frames import Frame
    from hannes.bench.messages import Ask, Kind, SetPoint

    board = BoardLogic(Standing())
    found = board.hear(Frame(Kind.ASK, 1, 0, Ask().pack()))
    found += board.hear(Frame(Kind.SET_POINT, 2, 0, SetPoint(10).pack()))
    return found + [each for _ in range(COUNT) for each in board.tick()]


def of_frames() -> bytes:
    """A log of a board that speaks in frames."""
    from hannes.bench.frames import encode

    return log("hannes", list(map(encode, frames())), {})


def of_servo() -> bytes:
    """A log of a servo that is polled."""
    from hannes.bench.adapters.feetech import packet

    return log("feetech", [packet(1, 0, bytes([k % 250] * 15)) for k in range(COUNT)],
               {"servo": 1, "rate": 100.0})  # fmt: skip


def framed(data: bytes, rng: Rng) -> bytes:
    """Frames changed before their check is made, moved or repeated; or the log as any other."""
    from hannes.bench.frames import encode

    if rng.random() < 2.0 * SHARE:
        return raw_log(data, rng)
    known = frames()
    for _ in range(rng.integers(1, 4)):
        k = int(rng.integers(0, len(known) if rng.random() < 0.5 else 6))
        known[k : k + 1] = _changed(known[k], rng)
    return log("hannes", list(map(encode, known)), {})


def _changed(frame: Any, rng: Rng) -> Iterator[Any]:
    kind = rng.integers(0, 6)
    if kind < 3:
        payload = bytearray(frame.payload)
        for place in rng.integers(0, len(payload), int(rng.integers(1, 9))):
            payload[place] = rng.integers(0, 256)
        yield replace(frame, payload=bytes(payload))
    elif kind == 3:
        number = int(rng.choice([0, 1, 2**20, 2**31, 2**32 - 1]))
        yield replace(frame, sequence=number, time=int(rng.integers(0, 2**63)))
    elif kind == 4:
        yield from (frame, replace(frame, sequence=frame.sequence + 1000))


def raw_log(data: bytes, rng: Rng) -> bytes:
    """Records of a raw log changed: its first line, stamps, lengths, bytes."""
    kind = rng.random()
    if kind < SHARE:
        return nasty.octets(data, rng)
    head, _, rest = data.partition(b"\n")
    if kind < 0.5:
        return as_json(head, rng) + b"\n" + rest
    new, at, cut = bytearray(rest), 0, []
    while at + RECORD.size <= len(rest):
        cut.append(at)
        at += RECORD.size + RECORD.unpack_from(rest, at)[2]
    for _ in range(rng.integers(1, 4)):
        place = cut[rng.integers(0, len(cut))]
        size = RECORD.unpack_from(rest, place)[2]
        if rng.random() < 0.15:
            struct.pack_into("<Q", new, place, int(rng.integers(0, 2**63)))
        elif size:
            new[place + RECORD.size + int(rng.integers(0, size))] = rng.integers(0, 256)
    return head + b"\n" + bytes(new)
