"""Experiments: what is declared, read, written and shipped."""
