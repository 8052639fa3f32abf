"""Limits of reading: the table of hannes/core/io/limits.py."""

from hannes.core.io.limits import LIMITS
from tools.reference.markdown import code, table

HEAD = """# Limits of reading

Files may come from anywhere.
Every reader therefore has limits, checked before the work.
Packed files are unpacked block by block, and no further than a limit.
What a file states about its own size is never believed.

Reading takes at most 16 bytes of memory for a byte of the file, unpacked, and 100 MiB.
Beyond a limit a file is refused in one line, exit status 2.
So is a file that is a device, a socket or a named pipe, and a link that leads out of an HDF5 file.
`python -m benchmarks.hostile` measures all this with thousands of damaged files for every reader.
"""


def page() -> str:
    """Text of the page."""
    rows = [(code(name), f"{each.value:,} {each.unit}", each.what) for name, each in LIMITS.items()]
    return f"{HEAD}\n{table(('limit', 'value', 'of what'), rows)}\n"
