"""Parts of the benchmark `naming`."""
