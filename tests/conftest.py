"""What all tests share."""

import signal

from hypothesis import settings

# A shell's background jobs start with Ctrl-C ignored, and so would all that they start.
signal.signal(signal.SIGINT, signal.default_int_handler)

# A first call compiles, which says nothing about the function.
settings.register_profile("compiled", deadline=None)
settings.load_profile("compiled")
