"""The shader that draws surface normals as colours."""

from __future__ import annotations

import threading

from sim.camera.shader import linked
from sim.gl import functions

STEPS, ZERO = 127, 128  # a component c of a normal is the byte ZERO + STEPS c

_VERTEX = """#version 120
varying vec3 normal;
void main() {
  normal = gl_NormalMatrix * gl_Normal;
  gl_Position = gl_ModelViewProjectionMatrix * gl_Vertex;
}
"""
# OpenGL's camera looks along -z with y up; the axes of the label are x right, y down, z forward.
_FRAGMENT = f"""#version 120
varying vec3 normal;
void main() {{
  vec3 own = normalize(normal) * vec3(1.0, -1.0, -1.0);
  gl_FragColor = vec4(({STEPS}.0 * own + {ZERO}.0) / 255.0, 1.0);
}}
"""

_local = threading.local()


class NormalShader:
    """The program that colours a pixel by the normal of its surface, in the camera's frame.

    The normal is that by which the surface is lit: of a mesh, interpolated between its vertices.
    Belongs to this thread's OpenGL context.
    """

    def __init__(self) -> None:
        self._program = linked(_VERTEX, _FRAGMENT)

    def use(self) -> None:
        """Colour what is drawn next by its normals."""
        functions().glUseProgram(self._program)

    def leave(self) -> None:
        """Hand drawing back to the fixed functions."""
        functions().glUseProgram(0)


def normal_shader() -> NormalShader:
    """The program, compiled once a thread.

    Raises InfrastructureError where the driver cannot compile it.
    """
    if "shader" not in _local.__dict__:
        _local.shader = NormalShader()
    shader: NormalShader = _local.shader
    return shader
