"""Poses that no motion makes: what labels must be right for."""

from dataclasses import replace

from scipy.spatial.transform import Rotation

from sim.person.rest import rest_pose
from sim.pose import Transform


def any_pose(anatomy, rng):
    """Hands anywhere before the person, turned any way, fingers bent by any amount."""
    turns = Rotation.random(3, rng=rng).as_matrix()[:2]
    nod = Rotation.from_rotvec(rng.normal(0.0, 0.3, 3)).as_matrix()
    palms = rng.uniform((0.25, -0.4, 0.8), (0.5, 0.4, 1.3), (2, 3))
    pose = rest_pose(anatomy)
    return replace(
        pose,
        head=Transform(pose.head.position_m, nod),
        hands=tuple(Transform(p, turn) for p, turn in zip(palms, turns, strict=True)),
        curls=rng.uniform(0, 1, (2, 5)),
    )
