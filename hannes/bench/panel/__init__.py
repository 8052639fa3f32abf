"""`hannes panel`: a hand on a port in a browser on the same machine."""
