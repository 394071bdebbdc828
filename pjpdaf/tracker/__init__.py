"""The PJPDAF tracker, thesis 3.2-3.6: ellipses of two views to positions in 3-D."""
