"""Each effect fitted on some stretches of a record and judged on others."""
