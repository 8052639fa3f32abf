"""Recordings and their files."""
