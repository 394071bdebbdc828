"""Pictures of frames: overlays of estimates and truth, sheets, stills, films."""
