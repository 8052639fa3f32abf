"""The hand's Jacobian and its factorisation."""
