"""Data quality of a recording, one file for each kind of check."""
