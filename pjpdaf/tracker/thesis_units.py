"""Units of Table 4.1 in SI.

The thesis prints no units; plots are in mm and the numbers fit mm and frames (3 frames/s, dt = 1
frame), so a variance of v mm^2 is v * 1e-6 m^2 and a velocity variance of v (mm/frame)^2 is
v * 1e-6 * 3^2 (m/s)^2.
"""

FRAME_S = 1.0 / 3.0  # one thesis frame [s], section 4.1
MM2 = 1e-6  # 1 mm^2 in m^2
MM2_PER_FRAME2 = 1e-6 / FRAME_S**2  # 1 (mm/frame)^2 in (m/s)^2
