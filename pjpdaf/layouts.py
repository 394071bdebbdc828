"""How footage holds the two views."""

from __future__ import annotations

from typing import Literal, get_args

# Both views in one picture: halves of its width or of its height, the left view first.
Layout = Literal["separate", "side-by-side", "top-bottom"]
LAYOUTS: tuple[Layout, ...] = get_args(Layout)
