"""Derivatives of plain functions by their text, and the lines that compute them."""
