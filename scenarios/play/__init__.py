"""Playing an episode, and its derived records: blame, error budget, recipe."""
