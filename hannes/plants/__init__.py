"""Machines that can be identified: their protocol, the hand, the axis, the finger."""
