"""Hostile files: thousands of mutants for every reader, each read or refused in one line."""
