"""Print the table of hidden effects: python -m benchmarks.truth.effects."""

from benchmarks.truth.effects import table

print(table())
