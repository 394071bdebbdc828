#!/bin/sh
# Tracks head and hands in footage of your own: calibrate once, then track.
# Needs four folders beside this script's working directory:
#   board/left  board/right    10-20 pairs of pictures of a 10 x 7 chessboard (9 x 6 inner corners)
#   film/left   film/right     the footage; its first 15 frames show the scene without the person
set -eu

pjpdaf-bench calibrate --left board/left --right board/right \
    --board 9x6 --square 0.025 --out calibration

pjpdaf-bench track --left film/left --right film/right \
    --calibration calibration/intrinsics.yml calibration/extrinsics.yml \
    --background-first 15 --fps 3 --out tracks

head -n 4 tracks/tracks.csv
