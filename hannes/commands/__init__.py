"""What a user types: the verbs and the command line."""
