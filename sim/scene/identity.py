"""The identity of a scene's room, body and rig: what two sequences must not share to differ."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, replace

from sim.specs import SceneSpec


@dataclass(frozen=True)
class SceneIdentity:
    """Digests of what was drawn; the same digest means the same thing.

    room: walls, furniture, table, clutter and light, without the objects of the motion; body: the
    person's measures and looks; rig: places, angles and focal length of the cameras.
    """

    room: str
    body: str
    rig: str


def identity_of(scene: SceneSpec) -> SceneIdentity:
    """The identity of a scene, 16 hexadecimal digits each."""
    return SceneIdentity(
        room=_digest(asdict(replace(scene.room, objects=()))),
        body=_digest([asdict(scene.anatomy), asdict(scene.appearance)]),
        rig=_digest(asdict(scene.rig)),
    )


def _digest(content: object) -> str:
    text = json.dumps(content, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
