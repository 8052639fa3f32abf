"""Foreign recordings: their columns mapped to channels, units and a clock."""
