"""Recordings as others write them: which column is which channel, in which unit, on which clock."""
