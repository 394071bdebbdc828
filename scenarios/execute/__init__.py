"""Execution of many episodes on isolated worker processes."""
