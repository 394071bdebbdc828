"""Labels of frames: instances, keypoints, masks, stereo matches, events, and their records."""
