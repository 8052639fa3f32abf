"""A single motor-driven axis as a plant."""
