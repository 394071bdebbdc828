"""The targets of the thesis, always in this order; the person's own sides."""

HEAD, RIGHT_HAND, LEFT_HAND = 0, 1, 2
HANDS = (RIGHT_HAND, LEFT_HAND)
TARGETS = ("head", "right_hand", "left_hand")
# Fig. 4.1: red tracker head, green right hand, blue left hand (RGB).
COLOURS_RGB = ((220, 60, 60), (60, 190, 80), (70, 90, 230))
