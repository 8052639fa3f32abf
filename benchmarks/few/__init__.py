"""Parts of the benchmark `few_runs`."""
