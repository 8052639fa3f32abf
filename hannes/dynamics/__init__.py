"""Mechanics of the hand: motor, wires, carts, fingers, joints, and effects upon them."""
