"""Rigid or soft, from motor current and position alone: features, trees, their file."""
