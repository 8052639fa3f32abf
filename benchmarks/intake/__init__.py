"""Faults put into sound logs: which of them `check` finds, names rightly, and mends by its key."""
