"""The gate: paired comparison of two runs, its statistics, and the files of its verdict."""
