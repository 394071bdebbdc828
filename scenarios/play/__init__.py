"""Playing an episode, and what is derived from it: blame, error budget, recipe."""
