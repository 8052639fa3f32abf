"""Tuning constants of the methods: fields of their frozen dataclasses, with unit and meaning."""


def page() -> str:
    """Text of the page."""
    return "# Tuning constants\n"
