"""A saved run: its rows, its files, and where it comes from."""
