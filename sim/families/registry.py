"""All families of motion by name. A registry is a dict."""

from __future__ import annotations

from collections.abc import Mapping

from sim.families import (
    both_hands_to_head,
    crossing,
    cyclic,
    drink,
    fast,
    hand_behind_head,
    hand_under_table,
    lean_and_reach,
    leave_view,
    merge_and_hold,
    mirror,
    object_splits_hand,
    one_view_occluder,
    parallel,
    pass_object,
    phone_at_ear,
    recorded,
    skin,
    stir_and_wipe,
    swap_hidden,
    table_work,
    touch_face,
)
from sim.motion.stage import Family

# In the order in which the schema and messages list the kinds of motion.
_MODULES = (
    *(table_work, stir_and_wipe, lean_and_reach),
    *(drink, touch_face, phone_at_ear, hand_behind_head),
    *(merge_and_hold, cyclic, pass_object),
    crossing,
    *(one_view_occluder, hand_under_table, leave_view),
    *(both_hands_to_head, object_splits_hand, skin),
    fast,
    *(mirror, swap_hidden, parallel),
    recorded,
)
FAMILIES: Mapping[str, Family] = {
    name: family for module in _MODULES for name, family in module.FAMILIES.items()
}
