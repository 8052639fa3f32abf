"""What all commands print alike: one JSON object on request."""

import argparse
import json
from typing import Any


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add the option --json."""
    parser.add_argument("--json", action="store_true", help="print one JSON object, nothing else")


def print_json(content: Any) -> None:
    """Print `content` as one JSON object; ValueError where a number is not finite."""
    print(json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False))


def add_force(parser: argparse.ArgumentParser) -> None:
    """Add the option --force."""
    parser.add_argument(
        "--force", action="store_true", help="replace results of another command, too"
    )


def add_describe(parser: argparse.ArgumentParser) -> None:
    """Add the option --describe."""
    parser.add_argument(
        "--describe",
        action="store_true",
        help="where nothing can be named, hand.toml takes the likeliest generic disturbance: a "
        "description, not a cause",
    )
