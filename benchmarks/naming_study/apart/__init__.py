"""The naming study of hands whose fingers differ, with effects up to the ends of their ranges."""
