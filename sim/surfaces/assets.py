"""Builds an MjSpec: textures, materials, meshes and visual geoms by name, each asset once."""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import lru_cache
from typing import Any

import numpy as np

from pjpdaf.arrays import Floats
from sim.gl import load_mujoco
from sim.randomness import generator
from sim.specs import RGB
from sim.surfaces import textures
from sim.surfaces.shapes import Surface, ellipsoid, limb
from sim.vectors import bone_frame

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
IDENTITY: Quaternion = (1.0, 0.0, 0.0, 0.0)


def _rng(seed: int, stream: str) -> np.random.Generator:
    return generator(seed, f"texture/{stream}")


@lru_cache(maxsize=32)  # to paint takes half the time of building a world; some 0.5 MB a texture
def _texture(
    seed: int, stream: str, paint: Callable[..., textures.Texture], *arguments: Any, **options: Any
) -> textures.Texture:
    texture = paint(_rng(seed, stream), *arguments, **options)
    texture.flags.writeable = False
    return texture


class Assets:
    """A spec under construction. All geoms are visual only: no contact, nothing moves by itself."""

    def __init__(self, spec: Any, seed: int) -> None:
        self.mujoco = load_mujoco()
        self.spec = spec
        self._seed = seed
        self._meshes: set[str] = set()

    def rng(self, stream: str) -> np.random.Generator:
        """The random generator of a texture."""
        return _rng(self._seed, stream)

    def texture(
        self, stream: str, paint: Callable[..., textures.Texture], *arguments: Any, **options: Any
    ) -> textures.Texture:
        """The texture `paint(rng, *arguments, **options)` of this stream; read only."""
        return _texture(self._seed, stream, paint, *arguments, **options)

    def quaternion(self, rotation: Floats) -> Quaternion:
        """Rotation matrix (3, 3) to MuJoCo's quaternion w, x, y, z."""
        quat = np.zeros(4)
        self.mujoco.mju_mat2Quat(quat, np.ascontiguousarray(rotation, dtype=np.float64).ravel())
        w, x, y, z = quat.tolist()
        return w, x, y, z

    def plain(
        self,
        name: str,
        rgb: RGB,
        specular: float = 0.05,
        shininess: float = 0.1,
        emission: float = 0.0,
    ) -> str:
        """Add a material of a single colour; returns its name."""
        self.spec.add_material(
            name=name,
            rgba=[*rgb, 1.0],
            specular=specular,
            shininess=shininess,
            emission=emission,
            reflectance=0.0,
        )
        return name

    def painted(
        self,
        name: str,
        picture: textures.Texture,
        specular: float = 0.02,
        shininess: float = 0.1,
        repeat: tuple[float, float] = (1.0, 1.0),
        emission: float = 0.0,
    ) -> str:
        """A material from a picture (h, w, 3) RGB; its name."""
        height, width = picture.shape[:2]
        texture = self.spec.add_texture(
            name=name,
            type=self.mujoco.mjtTexture.mjTEXTURE_2D,
            width=width,
            height=height,
            nchannel=3,
        )
        texture.data = np.ascontiguousarray(picture).tobytes()
        material = self.spec.add_material(
            name=name,
            specular=specular,
            shininess=shininess,
            emission=emission,
            reflectance=0.0,
        )
        material.textures[self.mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
        material.texrepeat = list(repeat)
        return name

    def cloth(self, name: str, rgb: RGB, pattern: str = "plain") -> str:
        """A material of woven cloth; its name."""
        return self.painted(name, self.texture(name, textures.cloth, rgb, pattern))

    def add(
        self,
        body: Any,
        name: str,
        surface: Surface,
        material: str,
        group: int,
        pos: Vector = (0.0, 0.0, 0.0),
        quat: Quaternion = IDENTITY,
        mesh: str = "",
        castshadow: bool = True,
    ) -> None:
        """A geom of a surface; geoms that name the same mesh share it."""
        mesh = mesh or name
        if mesh not in self._meshes:
            self._meshes.add(mesh)
            self.spec.add_mesh(
                name=mesh,
                uservert=surface.vertices_m.astype(np.float32).ravel().tolist(),
                usernormal=surface.normals.astype(np.float32).ravel().tolist(),
                usertexcoord=surface.uv.astype(np.float32).ravel().tolist(),
                userface=surface.faces.ravel().tolist(),
                inertia=self.mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
            )
        self._geom(
            body, name, material, group, pos, quat, "MESH", meshname=mesh, castshadow=castshadow
        )

    def box(
        self,
        body: Any,
        name: str,
        pos: Vector,
        half_m: Vector,
        material: str,
        group: int = 0,
        yaw_rad: float = 0.0,
        castshadow: bool = True,
    ) -> None:
        """A box by its half extents."""
        self._geom(
            body,
            name,
            material,
            group,
            pos,
            turned(yaw_rad),
            "BOX",
            size=list(half_m),
            castshadow=castshadow,
        )

    def plane(
        self,
        body: Any,
        name: str,
        pos: Vector,
        half_m: tuple[float, float],
        quat: Quaternion,
        material: str,
        group: int = 0,
    ) -> None:
        """A finite plane, visible from the side of its +z; its texture spans it once."""
        size = [*half_m, 0.1]
        self._geom(body, name, material, group, pos, quat, "PLANE", size=size, castshadow=False)

    def ellipsoid(
        self,
        body: Any,
        name: str,
        pos: Vector,
        half_m: Vector,
        material: str,
        group: int = 0,
    ) -> None:
        """An ellipsoid by its half axes.

        A mesh, as all that is round: the ids and depth that are drawn of MuJoCo's own round shapes
        are not those of the shapes, which its rays meet.
        """
        self.add(body, name, ellipsoid(np.array(half_m)), material, group, pos)

    def capsule(
        self,
        body: Any,
        name: str,
        ends: tuple[Any, Any],
        radius_m: float,
        material: str,
        group: int = 0,
        castshadow: bool = True,
    ) -> None:
        """A capsule between two points, a mesh as an ellipsoid is."""
        start, end = (np.asarray(point, dtype=np.float64) for point in ends)
        length = float(np.linalg.norm(end - start))
        surface = limb(length, np.full(2, radius_m), sides=14, rings=2, end_rings=3)
        quat = self.quaternion(bone_frame(start, end))
        pos = (float(start[0]), float(start[1]), float(start[2]))
        self.add(body, name, surface, material, group, pos, quat, castshadow=castshadow)

    def _geom(
        self,
        body: Any,
        name: str,
        material: str,
        group: int,
        pos: Vector,
        quat: Quaternion,
        kind: str,
        **extra: Any,
    ) -> None:
        body.add_geom(
            name=name,
            pos=list(pos),
            quat=list(quat),
            type=getattr(self.mujoco.mjtGeom, f"mjGEOM_{kind}"),
            material=material,
            group=group,
            contype=0,
            conaffinity=0,
            **extra,
        )


def turned(yaw_rad: float) -> Quaternion:
    """A turn about z as a quaternion w, x, y, z."""
    return (float(np.cos(yaw_rad / 2)), 0.0, 0.0, float(np.sin(yaw_rad / 2)))


def check_word(field: str, word: str, known: Collection[str]) -> None:
    """Raises ValueError for a word that is not among the known."""
    if word not in known:
        raise ValueError(f"{field} must be one of {', '.join(known)}, got {word!r}")
