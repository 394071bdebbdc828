"""`python -m scenarios` is the command pjpdaf-bench."""

from scenarios.cli import main

main()
