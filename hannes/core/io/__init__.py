"""Files, units, caches."""
