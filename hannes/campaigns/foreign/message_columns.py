"""Columns of message logs: MCAP, rosbag2 folders, ROS 1 bags.

A topic's numbers are `topic/field`; of a JointState those of a joint are `topic/position/NAME`,
`topic/velocity/NAME`, `topic/effort/NAME`. `topic/time` is the message's own stamp where it has
one, else when it was logged, in s since the log's first message.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from hannes.campaigns.foreign.bag_size import require_unpackable
from hannes.campaigns.foreign.binary_columns import Arrays, require_file
from hannes.campaigns.foreign.message_definitions import require_sized
from hannes.campaigns.foreign.nested import Records
from hannes.core.errors import BadInput
from hannes.core.io.bounded import deadline
from hannes.core.io.json_text import parsed
from hannes.core.io.limits import BYTES, COLUMNS, MIB
from hannes.core.io.optional import library

NANO = 1e-9
OF_JOINTS = ("position", "velocity", "effort")
MOST_MESSAGES = 20_000_000

Message = tuple[str, int, dict[str, Any], int]  # topic, time of logging [ns], fields, bytes


def open_messages(path: Path, missing: tuple[str, ...]) -> Arrays:
    """Read a log of messages; channels of one mapping must be of one topic."""
    topics: dict[str, Records] = {}
    start: int | None = None
    unpacked, late = 0, deadline(path)
    try:
        for topic, logged, fields, size in _messages(path):
            start = logged if start is None else start
            records = topics.setdefault(topic, Records(str(path), 0))
            records.decoded += size
            unpacked += size
            late()
            records.add({"time": _time(logged, fields, start), **fields})
            if len(topics) > COLUMNS or unpacked > BYTES:
                raise BadInput(f"{path}: more than {COLUMNS} topics or {BYTES // MIB} MiB; cut it")
    except BadInput:
        raise
    except Exception as error:  # a damaged file raises nearly anything from inside the library
        reason = " ".join(str(error).split())[:100]
        raise BadInput(f"{path}: cannot be read as a log of messages ({reason})") from None
    found = {
        f"{topic.strip('/')}/{name}": values
        for topic, records in topics.items()
        for name, values in records.columns().items()
    }
    if not found:
        raise BadInput(f"{path}: no message in it holds numbers that can be read")
    return Arrays(path, found, found.__getitem__, missing)


def _messages(path: Path) -> Iterator[Message]:
    if not path.is_dir():
        require_file(path)
    require_unpackable(path)
    if path.suffix.lower() == ".mcap" and not _is_ros(path):
        return _of_mcap(path)
    return _of_ros(path)


def _time(logged: int, fields: dict[str, Any], start: int) -> float:
    """Seconds since the first message: by the header's stamp where it is on that clock."""
    stamp = (
        fields.get("header", {}).get("stamp") if isinstance(fields.get("header"), dict) else None
    )
    if isinstance(stamp, dict) and {"sec", "nanosec"} <= stamp.keys():
        own = int(stamp["sec"]) * 10**9 + int(stamp["nanosec"])
        if own > 0:
            return (own - start) * NANO
    return (logged - start) * NANO


def _is_ros(path: Path) -> bool:
    """Whether the messages of an MCAP file are ROS's."""
    reader = library("mcap.reader", "formats")
    with path.open("rb") as file:
        summary = reader.make_reader(file).get_summary()
    encodings = {each.message_encoding for each in summary.channels.values()} if summary else set()
    return bool(encodings & {"cdr", "ros1"})


def _of_mcap(path: Path) -> Iterator[Message]:
    """Messages in JSON; those in other encodings are left out."""
    reader = library("mcap.reader", "formats")
    with path.open("rb") as file:
        for count, (_, channel, message) in enumerate(reader.make_reader(file).iter_messages()):
            if count > MOST_MESSAGES:
                raise BadInput(f"{path}: more than {MOST_MESSAGES} messages; cut it")
            if channel.message_encoding == "json":
                fields = parsed(message.data)
                if isinstance(fields, dict):
                    yield channel.topic, message.log_time, fields, len(message.data)


def _of_ros(path: Path) -> Iterator[Message]:
    rosbags = library("rosbags.highlevel", "formats")
    typesys = library("rosbags.typesys", "formats")
    store = typesys.get_typestore(typesys.Stores.LATEST)
    with rosbags.AnyReader([path], default_typestore=store) as reader:
        require_sized(reader.typestore.fielddefs, str(path))
        for connection, logged, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            yield connection.topic, logged, _fields(message), len(raw)


def _fields(message: Any) -> dict[str, Any]:
    """Fields of a ROS message; arrays of a JointState by joint."""
    fields = {name: _plain(value) for name, value in vars(message).items() if name[:2] != "__"}
    names = fields.pop("name", None)
    if isinstance(names, list) and names and all(isinstance(each, str) for each in names):
        for key in OF_JOINTS:
            values = fields.get(key)
            if isinstance(values, list) and len(values) == len(names):
                fields[key] = dict(zip(names, values, strict=True))
    return fields


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist() if value.size <= 64 else None  # no images
    if isinstance(value, list):
        return [_plain(each) for each in value[:64]]
    if hasattr(value, "__msgtype__"):
        return {name: _plain(each) for name, each in vars(value).items() if name[:2] != "__"}
    return value
