"""Silhouettes of a performance without rendering: projected shapes, painted by depth."""
