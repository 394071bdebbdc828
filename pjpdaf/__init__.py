"""Detector and tracker: beliefs about head and hands. Needs numpy, scipy, OpenCV."""
