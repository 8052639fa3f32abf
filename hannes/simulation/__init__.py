"""Equations to machine code, experiment to trajectory."""
