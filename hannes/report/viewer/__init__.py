"""`hannes view`: a hand in motion beside its channels, in one page that needs no network."""
