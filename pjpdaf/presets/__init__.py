"""Named sets of parameters of detector and tracker: a file each."""
