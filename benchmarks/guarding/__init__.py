"""Parts of the benchmark `guards`."""
