"""What is judged of each real machine."""
