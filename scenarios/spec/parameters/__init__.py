"""Parameters of a scenario: numbers with unit, range and distribution, choices, files."""
