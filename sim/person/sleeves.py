"""Arms as drawn: sleeves of any length, and the bare skin below them."""

from __future__ import annotations

from typing import Any

import numpy as np

from pjpdaf.arrays import Floats
from sim.anatomy import Anatomy
from sim.person.cloth import tailored
from sim.person.elbow import sleeve_above, sleeve_below
from sim.person.geoms import CLOTHES, HAND_TARGETS, TARGET_GROUPS
from sim.pose import SIDES
from sim.specs import Appearance
from sim.surfaces.assets import Assets
from sim.surfaces.shapes import limb, revolved

# Radii of an average arm at equal steps along a bone [m]. The forearm's have a last one, at the
# wrist, which follows the hand's breadth: WRIST_M of the sleeve, BARE_WRIST of that of the skin.
_SHOULDER_M, _ELBOW_M, WRIST_M = 0.0405, 0.043, 0.031
FORE_SLEEVE_M = (_ELBOW_M, 0.0455, 0.0415, 0.036)
FORE_SKIN_M, BARE_WRIST = (0.0360, 0.0405, 0.0365, 0.0295), 0.76
# Narrow where it leaves the shoulder, whose slope the torso has; and a little within the forearm's
# round end, which alone shows at the elbow.
UPPER_SLEEVE_M = (_SHOULDER_M, 0.0490, 0.0485, 0.0450, _ELBOW_M - 0.0010)
UPPER_SKIN_M = (0.0380, 0.0425, 0.0410, 0.0375, 0.0350)
SLEEVES = ("long", "rolled", "short")  # rolled: bare forearm; short: bare above the elbow as well
WRIST_DRAWN_IN = 0.90  # of its radius, at the end of the bare forearm
SHORT_SLEEVE, ROLLED_SLEEVE = 0.60, 0.30  # of the upper arm; of the forearm

_ALONG_X = (0.7071068, 0.0, 0.7071068, 0.0)  # z of a body of revolution to x


def add_arm(
    assets: Assets, upper: Any, fore: Any, anatomy: Anatomy, side: str, appearance: Appearance
) -> None:
    """Add a sleeve to the posed bodies `upper` and `fore`, and below it the bare arm."""
    k = anatomy.stature_m / 1.72
    wrist = WRIST_M * anatomy.hand_breadth_m / 0.0851
    # A little short of the wrist, where the hand's own skin begins.
    long_m, upper_m = anatomy.forearm_m - 0.012, anatomy.upper_arm_m
    cloth = np.array([*FORE_SLEEVE_M, wrist / k]) * k
    skin = np.array([*FORE_SKIN_M, BARE_WRIST * wrist / k]) * k
    # The sleeve on the upper arm, and then the bare skin below it.
    if appearance.sleeves == "short":
        ends = np.array([_SHOULDER_M, 0.0480, 0.0485, 0.0475, 0.0480]) * k
        _sleeve(
            assets,
            upper,
            f"upper_arm:{side}",
            SHORT_SLEEVE * upper_m,
            ends,
            0.003,
            from_elbow=False,
        )
        surface = limb(upper_m, np.array(UPPER_SKIN_M) * k, sides=20, rings=8)
        assets.add(upper, f"bare:upper_arm:{side}", surface, "skin", CLOTHES)
    else:
        surface = limb(upper_m, np.array(UPPER_SLEEVE_M) * k, sides=22, rings=9, end_rings=5)
        surface = sleeve_above(surface, upper_m)
        assets.add(upper, f"upper_arm:{side}", surface, "shirt", CLOTHES)
    if appearance.sleeves == "long":
        surface = limb(long_m, cloth, sides=22, rings=9, end_rings=5, far_cap=0.15)
        surface = sleeve_below(surface, float(cloth[0]))
        assets.add(fore, f"forearm:{side}", surface, "shirt", CLOTHES)
        _cuff(assets, fore, side, long_m, wrist)
        return
    if appearance.sleeves == "rolled":
        ends = np.array([1.0, 1.06, 1.08]) * cloth[0]
        _sleeve(
            assets, fore, f"forearm:{side}", ROLLED_SLEEVE * long_m, ends, 0.006, from_elbow=True
        )
    # Drawn in at the wrist, so that the hand's own goes on without a step.
    skin = np.interp(np.linspace(0, 1, 13), np.linspace(0, 1, 5), skin)
    skin[-1] *= WRIST_DRAWN_IN
    surface = limb(long_m, skin, sides=20, rings=13, far_cap=0.60)
    assets.add(fore, f"bare:forearm:{side}", surface, "skin", CLOTHES)
    # The same wrist once more with the hand, as the cuff of a long sleeve: in the amodal pass it
    # hides the stub that reaches into the forearm. Thinner, so that the forearm covers it.
    stub = limb(
        0.030, skin[-1] * np.array([1.10 / WRIST_DRAWN_IN, 0.985]), sides=20, rings=3, far_cap=0.14
    )
    group = TARGET_GROUPS[HAND_TARGETS[SIDES.index(side)]]
    at = (long_m - 0.030, 0.0, 0.0)
    assets.add(fore, f"wrist:{side}", stub, "skin", group, pos=at, castshadow=False)


def _sleeve(
    assets: Assets,
    body: Any,
    name: str,
    length_m: float,
    radii_m: Floats,
    hem_m: float,
    from_elbow: bool,
) -> None:
    """A sleeve that ends on the way, with a hem or a rolled cuff that is hem_m thick."""
    surface = limb(length_m, radii_m, sides=22, rings=6, end_rings=5, far_cap=0.05)
    surface = sleeve_below(surface, float(radii_m[0])) if from_elbow else tailored(surface, 0)
    assets.add(body, name, surface, "shirt", CLOTHES)
    r, wide = float(radii_m[-1]), 0.012 + 3.5 * hem_m
    outline = np.array(
        [
            [r - 0.010, -wide],
            [r + 0.6 * hem_m, -wide],
            [r + hem_m, -0.75 * wide],
            [r + hem_m, -0.15 * wide],
            [r + 0.6 * hem_m, 0.0],
            [r - 0.010, 0.0],
        ]
    )
    hem = tailored(revolved(outline, 22), 2)
    assets.add(
        body, f"hem:{name}", hem, "shirt", CLOTHES, pos=(length_m + 0.004, 0.0, 0.0), quat=_ALONG_X
    )


def _cuff(assets: Assets, fore: Any, side: str, long_m: float, wrist_m: float) -> None:
    """The end of a long sleeve. With the hand's group, as the collar is with the head's."""
    cuff = revolved(
        np.array(
            [
                [wrist_m * 0.93, -0.020],
                [wrist_m + 0.0012, -0.018],
                [wrist_m - 0.0005, 0.001],
                [wrist_m - 0.0020, 0.005],
                [wrist_m - 0.0048, 0.005],
                [wrist_m - 0.0058, -0.004],
            ]
        ),
        20,
    )
    group = TARGET_GROUPS[HAND_TARGETS[SIDES.index(side)]]
    at = (long_m - 0.003, 0.0, 0.0)
    cuff = tailored(cuff, 2)
    assets.add(fore, f"cuff:{side}", cuff, "shirt", group, pos=at, quat=_ALONG_X)
