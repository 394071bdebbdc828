"""The families of motion, a module per kind of difficulty."""
