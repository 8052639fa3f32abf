"""Kills of every verb that writes: `python -m benchmarks.kills`."""
