"""From recordings to parameters and missing effects."""
