"""`python -m hannes` is `hannes`: without the current folder, which may be anybody's data."""

import os
import sys

if not sys.flags.safe_path and os.path.realpath(sys.path[0]) == os.path.realpath(os.curdir):
    if os.path.realpath(os.curdir) != os.path.dirname(os.path.dirname(os.path.realpath(__file__))):
        del sys.path[0]

from hannes.commands.cli import main

if __name__ == "__main__":
    sys.exit(main())
