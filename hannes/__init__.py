"""A model of the Hannes prosthetic hand that says what it is missing when a recording disagrees."""

__version__ = "0.1.0"
