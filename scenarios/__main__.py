"""`python -m scenarios` is the command pjpdaf-bench."""

from pjpdaf.entry import main

main()
