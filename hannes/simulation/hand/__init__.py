"""The hand: equations, variables, anatomy, Jacobian."""
