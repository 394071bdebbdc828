"""The verb `score`: tracks of other programs on a data set."""
