"""The shader that lights and textures a scene in one pass.

MuJoCo draws a scene with a shadow twice a view, and its shadow map once a view: OpenGL's fixed
functions light a vertex with all lights or with none. With this program in their place it draws a
view once, with the same lights, materials and textures, and any shadow map serves both views.
"""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pjpdaf.arrays import Floats
from pjpdaf.errors import InfrastructureError
from sim.gl import REMEDY, functions, load_mujoco
from sim.surroundings.lights import SHARP_M

TEXTURED = 0.999  # alpha of a textured geom; MuJoCo takes all above 0.995 as opaque
MOST_SHADOWS = 2  # lights with shadows
_PICTURE_UNIT, _SHADOW_UNITS = 0, (1, 2)

# As the fixed functions: per vertex, infinite lights, a local viewer; each sum is clamped to 1.
_VERTEX = """#version 120
uniform mat4 eye_to_map;
varying vec3 steady, shadowed, at;
varying vec2 uv;
varying float textured;
DECLARED
void main() {
  vec4 eye = gl_ModelViewMatrix * gl_Vertex;
  vec3 normal = normalize(gl_NormalMatrix * gl_Normal);
  vec3 to_eye = normalize(-eye.xyz);
  float facing;
  vec3 halfway;
  steady = gl_FrontMaterial.emission.rgb;
  shadowed = vec3(0.0);
BLACK
LIGHTS
  steady = min(steady, 1.0);
  shadowed = min(shadowed, 1.0);
  at = (eye_to_map * eye).xyz;
PLACED
  uv = (gl_TextureMatrix[0] * gl_MultiTexCoord0).xy;
  textured = gl_Color.a < OPAQUE ? 1.0 : 0.0;
  gl_Position = gl_ModelViewProjectionMatrix * gl_Vertex;
}
"""
_AMBIENT = "  SUM += gl_Color.rgb * LIGHT.ambient.rgb;\n"
_FACING = "  facing = max(dot(normal, normalize(LIGHT.position.xyz)), 0.0);\n"
_DIFFUSE = "  SUM += facing * gl_Color.rgb * LIGHT.diffuse.rgb;\n"
_SPECULAR = """  halfway = normalize(normalize(LIGHT.position.xyz) + to_eye);
  if (facing > 0.0) SUM += gl_FrontMaterial.specular.rgb * LIGHT.specular.rgb
    * pow(max(dot(normal, halfway), 0.0), gl_FrontMaterial.shininess);
"""
_FRAGMENT = """#version 120
uniform sampler2D picture;
uniform sampler2DShadow map;
varying vec3 steady, shadowed, at;
varying vec2 uv;
varying float textured;
DECLARED
SHADOW
void main() {
  vec3 colour = steady + LIT * shadowed;
SECOND
  vec3 texel = texture2D(picture, uv).rgb;
  gl_FragColor = vec4(textured > 0.5 ? colour * texel : colour, 1.0);
}
"""
# A second light with shadows: its own sum, place on its own map, and share that reaches a point.
_SECOND_VERTEX = {
    "DECLARED": "uniform mat4 eye_to_map2;\nvarying vec3 shadowed2, at2;",
    "BLACK": "  shadowed2 = vec3(0.0);",
    "PLACED": "  shadowed2 = min(shadowed2, 1.0);\n  at2 = (eye_to_map2 * eye).xyz;",
}
_SECOND_FRAGMENT = {
    "DECLARED": "uniform sampler2DShadow map2;\nvarying vec3 shadowed2, at2;",
    "SECOND": "  colour += LIT2 * shadowed2;",
}
# The share of the light that reaches twelve places on a disc of the map about the point (Vogel's
# spiral): percentage-closer filtering (Reeves, Salesin and Cook 1987). soft: the disc's radius, and
# the depth that a surface may fall within it.
_SOFT_SHADOW = """uniform vec2 soft;
float lit(sampler2DShadow map, vec3 at) {
  float sum = 0.0;
  for (int i = 0; i < 12; i++) {
    float turn = 2.399963 * float(i), reach = soft.x * sqrt((float(i) + 0.5) / 12.0);
    sum += shadow2D(map, at + vec3(reach * cos(turn), reach * sin(turn), soft.y)).r;
  }
  return sum / 12.0;
}"""
_SOFT_SLOPE = 1.2  # of a surface, seen from the light, that does not shade itself

_local = threading.local()


@dataclass(frozen=True)
class LightKind:
    """The parts of a light that are not black, whether it casts the shadow, and if that is soft."""

    ambient: bool
    diffuse: bool
    specular: bool
    shadow: bool
    soft: bool = False

    def statements(self, number: int, shadowed: str = "shadowed") -> str:
        """The statements of the vertex shader that add this light; `shadowed`: the sum it goes to
        if it casts shadows.
        """
        text = _AMBIENT * self.ambient
        if self.diffuse or self.specular:
            text += _FACING + _DIFFUSE * self.diffuse + _SPECULAR * self.specular
        total = shadowed if self.shadow else "steady"
        return text.replace("SUM", total).replace("LIGHT", f"gl_LightSource[{number}]")


def soft_edge_m(light: Any) -> float:
    """Half the width [m] of the edges of a light's (MjvLight) shadows; 0 where they are sharp."""
    edge = float(light.bulbradius) - SHARP_M
    return edge if light.castshadow and edge > 1e-6 else 0.0


def kinds_of(lights: Sequence[Any]) -> tuple[LightKind, ...]:
    """The kinds of a scene's lights (MjvLight), in order.

    Raises ValueError where one is not directional, or more than MOST_SHADOWS cast shadows.
    """
    directional = int(load_mujoco().mjtLightType.mjLIGHT_DIRECTIONAL)
    if any(light.type != directional for light in lights):
        raise ValueError("a scene's lights must be directional")
    kinds = tuple(
        LightKind(
            ambient=bool(np.any(light.ambient)),
            diffuse=bool(np.any(light.diffuse)),
            specular=bool(np.any(light.specular)),
            shadow=bool(light.castshadow),
            soft=soft_edge_m(light) > 0.0,
        )
        for light in lights
    )
    if sum(kind.shadow for kind in kinds) > MOST_SHADOWS:
        raise ValueError(f"only {MOST_SHADOWS} lights of a scene may cast shadows")
    return kinds


def mark_textured(model: Any) -> None:
    """Give textured geoms of a model the alpha by which the shader knows them; safe to repeat."""
    textured = np.any(model.mat_texid >= 0, axis=1)
    model.mat_rgba[textured, 3] = TEXTURED
    by_geom = np.append(textured, False)[model.geom_matid]  # the last is for -1, no material
    # A geom's own colour, where it has one, is drawn in place of its material's.
    own = np.any(model.geom_rgba != np.array([0.5, 0.5, 0.5, 1.0], np.float32), axis=1)
    model.geom_rgba[by_geom & own, 3] = TEXTURED


@dataclass(frozen=True, eq=False)
class BoundMap:
    """A shadow map: eye_to_map (4, 4) to its coordinates, and OpenGL's name of its texture."""

    eye_to_map: Floats
    texture: int


class Shader:
    """The program for scenes with these lights; belongs to this thread's OpenGL context."""

    def __init__(self, kinds: tuple[LightKind, ...]) -> None:
        gl = self._gl = functions()
        vertex, fragment = _sources(kinds)
        self._program = linked(vertex, fragment)
        gl.glUseProgram(self._program)
        units = (_PICTURE_UNIT, *_SHADOW_UNITS)
        for name, unit in zip((b"picture", b"map", b"map2"), units, strict=True):
            gl.glUniform1i(self._place(name), unit)  # a name that is not used is at -1: no effect
        self._eye_to_maps = self._place(b"eye_to_map"), self._place(b"eye_to_map2")
        self._soft = self._place(b"soft")
        gl.glUseProgram(0)

    def _place(self, name: bytes) -> int:
        return int(self._gl.glGetUniformLocation(self._program, name))

    def use(self, maps: Sequence[BoundMap], edge_m: float = 0.0) -> None:
        """Colour what is drawn next, with the maps of the lights with shadows in their order.

        edge_m: half width of soft edges.
        """
        gl = self._gl
        gl.glUseProgram(self._program)
        for place, unit, shadows in zip(self._eye_to_maps, _SHADOW_UNITS, maps, strict=False):
            # OpenGL's order: columns.
            values = np.ascontiguousarray(shadows.eye_to_map.T, dtype=np.float32)
            pointer = values.ctypes.data_as(ctypes.POINTER(ctypes.c_float))
            gl.glUniformMatrix4fv(place, 1, 0, pointer)
            gl.glActiveTexture(gl.GL_TEXTURE0 + unit)
            gl.glBindTexture(gl.GL_TEXTURE_2D, shadows.texture)
        if self._soft >= 0:
            rows = maps[0].eye_to_map  # all maps have the same scale
            across, along = (float(np.linalg.norm(rows[row, :3])) for row in (0, 2))
            gl.glUniform2f(self._soft, across * edge_m, along * _SOFT_SLOPE * edge_m)
        gl.glActiveTexture(gl.GL_TEXTURE0 + _PICTURE_UNIT)

    def leave(self) -> None:
        """Hand drawing back to the fixed functions."""
        self._gl.glUseProgram(0)


def _sources(kinds: tuple[LightKind, ...]) -> tuple[str, str]:
    """The texts of the vertex and the fragment shader for these lights."""
    casting = [number for number, kind in enumerate(kinds) if kind.shadow]
    second = casting[1] if len(casting) > 1 else -1
    lights = "".join(
        kind.statements(number, "shadowed2" if number == second else "shadowed")
        for number, kind in enumerate(kinds)
    )
    soft = any(kind.soft for kind in kinds)
    lit = "lit(map, at)" if soft else "shadow2D(map, at).r"
    texts = {"LIGHTS": lights, "OPAQUE": f"{(1 + TEXTURED) / 2:.6f}"}
    vertex = _filled(_VERTEX, {**_SECOND_VERTEX, **texts}, second >= 0)
    texts = {"LIT2": lit.replace("map, at", "map2, at2"), "LIT": lit if casting else "1.0"}
    texts["SHADOW"] = _SOFT_SHADOW if soft else ""
    return vertex, _filled(_FRAGMENT, {**_SECOND_FRAGMENT, **texts}, second >= 0)


def _filled(template: str, texts: Mapping[str, str], two: bool) -> str:
    """A template with its words in capitals replaced; those of a second light only where two."""
    seconds = _SECOND_VERTEX.keys() | _SECOND_FRAGMENT.keys()
    for word, text in texts.items():
        template = template.replace(word, text if two or word not in seconds else "")
    return template


def shader_of(kinds: tuple[LightKind, ...]) -> Shader:
    """The program for these lights, compiled once a thread.

    Raises InfrastructureError where the driver cannot compile it.
    """
    known = _local.__dict__.setdefault("shaders", {})
    if kinds not in known:
        known[kinds] = Shader(kinds)
    shader: Shader = known[kinds]
    return shader


def linked(vertex: str, fragment: str) -> Any:
    """The program of a vertex and a fragment shader, in this thread's OpenGL context.

    Raises InfrastructureError where the driver refuses it.
    """
    gl = functions()
    program = gl.glCreateProgram()
    for kind, source in ((gl.GL_VERTEX_SHADER, vertex), (gl.GL_FRAGMENT_SHADER, fragment)):
        gl.glAttachShader(program, _compiled(kind, source))
    gl.glLinkProgram(program)
    _check(gl.glGetProgramiv, gl.glGetProgramInfoLog, program, gl.GL_LINK_STATUS)
    return program


def _compiled(kind: int, source: str) -> Any:
    gl = functions()
    shader = gl.glCreateShader(kind)
    text = ctypes.cast(
        ctypes.pointer(ctypes.c_char_p(source.encode())),
        ctypes.POINTER(ctypes.POINTER(ctypes.c_char)),
    )
    gl.glShaderSource(shader, 1, text, None)
    gl.glCompileShader(shader)
    _check(gl.glGetShaderiv, gl.glGetShaderInfoLog, shader, gl.GL_COMPILE_STATUS)
    return shader


def _check(status_of: Any, log_of: Any, thing: Any, question: Any) -> None:
    """Raise InfrastructureError where a shader or program was refused by the driver."""
    status = ctypes.c_int(0)
    status_of(thing, question, ctypes.byref(status))
    if not status.value:
        log = ctypes.create_string_buffer(500)
        log_of(thing, len(log), None, log)
        cause = log.value.decode(errors="replace").strip().partition("\n")[0]
        raise InfrastructureError(f"the OpenGL driver refuses our shader ({cause})", REMEDY)
