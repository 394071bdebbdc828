"""Detector and tracker: what is believed about head and hands. Needs numpy, scipy, OpenCV."""
