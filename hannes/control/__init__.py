"""Controller, drive, encoder and reference, and effects upon them."""
