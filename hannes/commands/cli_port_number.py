"""Port numbers of TCP, as options take them."""

import argparse


def port_number(text: str) -> int:
    """A port number; argparse's error, which names the option, where it is none."""
    from hannes.bench.port import HIGHEST

    number = int(text) if text.isascii() and text.isdigit() and len(text) < 9 else -1
    if not 0 <= number <= HIGHEST:
        raise argparse.ArgumentTypeError(
            f"expected a port from 0 to {HIGHEST} (0: any that is free), found {text[:60]!r}"
        )
    return number
