"""Parts of the benchmark `calibration`."""
