"""What compiled formulas are made of."""
