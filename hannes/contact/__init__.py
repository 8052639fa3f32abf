"""Contact of phalanges with objects, and effects upon it."""
