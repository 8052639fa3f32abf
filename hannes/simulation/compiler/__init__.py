"""Any plant's written equations and effects, to machine code."""
