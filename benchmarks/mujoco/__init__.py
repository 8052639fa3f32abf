"""The hand in MuJoCo: with the hand's own equations, and in MuJoCo's own elements."""
