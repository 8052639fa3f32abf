"""The hand on a cable, or a virtual one: link, board, recorder, live recognition, grip policy."""
