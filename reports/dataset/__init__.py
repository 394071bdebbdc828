"""Presentation of a data set: card, page, sheet, recording for a viewer."""
