"""The motion of a scenario: a kind of ours, a script of gestures, a plug-in."""
