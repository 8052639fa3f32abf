"""The third plant: one finger that closes on a fixed object, with its force sensor."""
