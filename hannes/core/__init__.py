"""Declarations and tools that know no hand."""
