"""What all tests share."""

from hypothesis import settings

# A first call compiles, which says nothing about the function.
settings.register_profile("compiled", deadline=None)
settings.load_profile("compiled")
