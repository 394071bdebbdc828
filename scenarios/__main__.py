"""`python -m scenarios` is the command pjpdaf-bench."""

from scenarios.cli.main import main

main()
