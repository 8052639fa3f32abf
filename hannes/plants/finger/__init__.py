"""The third plant: one finger that closes on a fixed object, and tells the force it feels."""
