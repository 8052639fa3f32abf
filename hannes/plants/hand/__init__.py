"""The hand as a plant."""
