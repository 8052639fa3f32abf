"""What may be wrong with a recording, one file for each part of it that can go wrong."""
