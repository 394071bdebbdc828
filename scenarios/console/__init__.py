"""Progress, tables, interrupts and output folders of the verbs."""
