"""One pass by our shader against MuJoCo's own drawing, which takes a pass more for the shadow."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from pjpdaf.errors import InfrastructureError
from sim.camera.render import StereoRenderer
from sim.camera.shader import LightKind, Shader, kinds_of, shader_of, soft_edge_m
from sim.gl import load_mujoco
from sim.person.rest import rest_pose
from sim.scene.world import build
from sim.specs import ObjectSpec, RigSpec, RoomSpec, SceneSpec
from sim.surroundings.lights import SHARP_M

CHAIR = ObjectSpec("chair", "chair", (0.44, 0.44, 0.92), (0.7, 0.5, 0.4), (-0.7, 0.6), base_m=0.0)
SCENE = SceneSpec(rig=RigSpec(tilt_rad=0.28), room=RoomSpec(objects=(CHAIR,)))


def drawn_by_mujoco(world):
    """The left view, by MuJoCo's two passes and shadow map."""
    mujoco = load_mujoco()
    scene = mujoco.MjvScene(world.model, maxgeom=500)
    with_context = mujoco.MjrContext(world.model, mujoco.mjtFontScale.mjFONTSCALE_100)
    mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, with_context)
    option, camera = mujoco.MjvOption(), mujoco.MjvCamera()
    option.geomgroup[:] = 1
    camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, 0
    every = mujoco.mjtCatBit.mjCAT_ALL
    mujoco.mjv_updateScene(world.model, world.data, option, None, camera, every, scene)
    scene.flags[:] = 0
    for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_CULL_FACE):
        scene.flags[flag] = 1
    rgb = np.empty((960, 1280, 3), np.uint8)
    viewport = mujoco.MjrRect(0, 0, 1280, 960)
    mujoco.mjr_render(viewport, scene, with_context)
    mujoco.mjr_readPixels(rgb, None, viewport, with_context)
    with_context.free()
    return cv2.resize(rgb, (640, 480), interpolation=cv2.INTER_AREA)[::-1, :, ::-1]


@pytest.mark.parametrize("lights", [1, 2])
def test_lights_materials_textures_and_shadows_are_mujocos(lights):
    world = build(SCENE)
    world.model.light_castshadow[:lights] = 1  # key and fill
    if lights == 2:
        world.model.light_dir[1] = np.array([-0.5, 0.6, -0.62])  # from above: it has shadows
    world.place(rest_pose(SCENE.anatomy))
    with StereoRenderer(world) as renderer:
        ours = renderer.view(0, labels=False, amodal=False).colour
        theirs = drawn_by_mujoco(world)
        assert (renderer.view(0, labels=False, amodal=False).colour == ours).all()
    steps = np.abs(ours.astype(int) - theirs).max(axis=-1)
    # It rounds once a shadow and once more, and its shadow map is half a texel off.
    assert steps.mean() < 0.7 * lights
    assert (steps > 2).mean() < 0.006 * lights


def light(**changes):
    directional = load_mujoco().mjtLightType.mjLIGHT_DIRECTIONAL
    values = {
        "type": directional,
        "ambient": np.zeros(3),
        "diffuse": np.ones(3),
        "specular": np.zeros(3),
        "castshadow": 0,
        "bulbradius": SHARP_M,
    }
    return SimpleNamespace(**values | changes)


def test_kinds_of_lights():
    head = light(ambient=np.ones(3), diffuse=np.zeros(3))
    assert kinds_of([head, light(castshadow=1)]) == (
        LightKind(ambient=True, diffuse=False, specular=False, shadow=False),
        LightKind(ambient=False, diffuse=True, specular=False, shadow=True),
    )
    (soft,) = kinds_of([light(castshadow=1, bulbradius=SHARP_M + 0.004)])
    assert soft.soft
    assert soft_edge_m(light(bulbradius=SHARP_M + 0.004)) == 0.0
    with pytest.raises(ValueError, match="only 2 lights of a scene may cast shadows"):
        kinds_of([light(castshadow=1)] * 3)
    with pytest.raises(ValueError, match="must be directional"):
        kinds_of([light(type=load_mujoco().mjtLightType.mjLIGHT_SPOT)])


def test_a_driver_that_refuses_the_shader_is_named(monkeypatch):
    with StereoRenderer(build(SCENE)):
        kind = LightKind(ambient=True, diffuse=True, specular=True, shadow=True)
        assert shader_of((kind,)) is shader_of((kind,))
        monkeypatch.setattr(LightKind, "statements", lambda *_: "no GLSL;")
        with pytest.raises(InfrastructureError, match="the OpenGL driver refuses our shader"):
            Shader((kind,))
