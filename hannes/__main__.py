"""`python -m hannes` is `hannes`."""

import sys

from hannes.commands.cli import main

if __name__ == "__main__":
    sys.exit(main())
