"""A recording as an MCAP log, which Foxglove and ROS tools open: one JSON message a sample."""

import io
import json

from hannes.core.io.optional import library
from hannes.core.recording.frames import Samples, metadata

TOPIC = "/hannes/recording"
NANOSECONDS = 1e9


def dump(recording: Samples) -> bytes:
    """The file, not compressed; log time is the recording's time in ns from its own zero.

    Each message has fields such as `current_A`; metadata stands in a record of that name.
    """
    mcap, buffer = library("mcap.writer", "export"), io.BytesIO()
    writer = mcap.Writer(buffer, compression=mcap.CompressionType.NONE)
    writer.start(profile="", library="hannes")
    fields = {name: f"{name}_{recording.units[name]}" for name in recording.names}
    schema = writer.register_schema("hannes.Recording", "jsonschema", _schema(fields))
    channel = writer.register_channel(TOPIC, "json", schema)
    columns = [(fields[name], recording.channels[name].tolist()) for name in recording.names]
    first = min(0.0, float(recording.time[0]))  # a log's times are never negative
    for k, time in enumerate(recording.time.tolist()):
        message = json.dumps({name: values[k] for name, values in columns}).encode()
        stamp = round((time - first) * NANOSECONDS)
        writer.add_message(channel, log_time=stamp, publish_time=stamp, data=message)
    known = metadata(recording) | ({"time_offset_s": first} if first else {})
    writer.add_metadata("recording", {name: str(value) for name, value in known.items()})
    writer.finish()
    return buffer.getvalue()


def _schema(fields: dict[str, str]) -> bytes:
    properties = {name: {"type": "number"} for name in fields.values()}
    return json.dumps({"type": "object", "properties": properties}).encode()
