"""What to play, and the command line."""
