"""What a residual goes with: where it is, what it grows with, both ways alike or not."""
