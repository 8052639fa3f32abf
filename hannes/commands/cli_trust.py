"""The command that remembers consent to Python, and the option that gives it once."""

import argparse
from collections.abc import Callable

EXAMPLES = {
    "trust": """\
hannes trust campaign.toml           remember that its Python may run, until a byte changes
hannes trust campaign.toml --forget
what may run what: docs/explanation/trust.md""",
}


def add(command: Callable[..., argparse.ArgumentParser]) -> None:
    """Add the command; `command(name, call, description)` makes its parser."""
    trust = command("trust", _trust, "remember that the Python a TOML file names may run")
    trust.add_argument("file", help="a campaign, experiment, mapping or hand file (.toml)")
    trust.add_argument("--forget", action="store_true", help="ask again from now on")


def add_trust(parser: argparse.ArgumentParser) -> None:
    """Add the option --trust."""
    parser.add_argument(
        "--trust", action="store_true", help="run Python of its own that a TOML file names"
    )


def _trust(chosen: argparse.Namespace) -> None:
    from pathlib import Path

    from hannes.core.errors import BadInput
    from hannes.core.trust import consent

    file = Path(chosen.file)
    if file.suffix != ".toml":
        raise BadInput(
            f"{file}: expected a TOML file, for data never runs Python, and Python that you name "
            "yourself may run"
        )
    if chosen.forget:
        known = consent.forget(file)
        print(f"{file}: {'forgotten' if known else 'nothing was remembered'}")
        return
    found = consent.remember(file)
    if not found:
        print(f"{file} names no Python of its own: there is nothing to trust")
    for path, sources in found.items():
        print(f"{path} may run, until a byte of it or of these changes:")
        print("\n".join(f"  {each.name}, from {each.origin}" for each in sources))
