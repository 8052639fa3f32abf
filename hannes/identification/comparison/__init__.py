"""The paper's own comparison, for recordings of a user: its metrics, measured and simulated.

Table II and equation 4 of the paper. Nothing is fitted.
"""
