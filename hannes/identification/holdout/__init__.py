"""Each effect fitted on some segments of the recordings and judged on others (hold-out)."""
