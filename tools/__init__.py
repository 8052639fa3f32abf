"""Commands of those who build hannes."""
