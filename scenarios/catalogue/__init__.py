"""The catalogue of scenarios as text, pages, films and measurements."""
