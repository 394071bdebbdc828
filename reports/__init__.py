"""How well it went: scores, saved runs, figures and pages. Records in, records and files out."""
