"""Progress, interrupts and output folders of the long verbs."""
