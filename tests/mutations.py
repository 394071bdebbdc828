"""Damage to files as strangers, editors and bad disks do it: for fuzz tests of readers."""

from __future__ import annotations

import copy
import json
import re

import pyarrow as pa
import pyarrow.parquet as pq
from hypothesis import strategies as st

# Words in the place of a word; most are of another type, too large, or of no sense.
WORDS = (
    "", "x", "-1", "0", "1e308", "-1e-300", "nan", ".inf", "9" * 400, "1e-7", "[]", "{}",
    "[1, [2]]",
    "{a: b}", "null", "true", "\x1b]0;t\x07", "\u202e", "ä" * 300, "../../x", "~", "!!p/x",
    "*a", "&a", "'", '"', "- - -", "0x1f", "1_000", "2026-01-01", "#", "%",
)  # fmt: skip
VALUES = (
    None, True, -1, 0, 2**70, 1e308, -1e-300, "", "x", "\x1b[0m", "\ud800", "../x", "9" * 400, [],
    {},
    [[]], [None], {"a": {}}, ["a"] * 3, {"x": 1}, [{"x": []}], "a\nb", float("nan"), float("inf"),
)  # fmt: skip


@st.composite
def damaged_text(draw, text: str) -> bytes:
    """A text with words replaced, lines repeated, removed or exchanged, and bytes changed."""
    lines = text.split("\n")
    for _ in range(draw(st.integers(1, 3))):
        at = draw(st.integers(0, len(lines) - 1))
        kind = draw(st.integers(0, 5))
        if kind == 0:
            lines[at : at + draw(st.integers(1, 3))] = []
        elif kind == 1:
            lines.insert(at, lines[draw(st.integers(0, len(lines) - 1))])
        elif kind == 2:
            other = draw(st.integers(0, len(lines) - 1))
            lines[at], lines[other] = lines[other], lines[at]
        elif words := list(re.finditer(r"[^\s,:\[\]{}]+", lines[at])):
            word = words[draw(st.integers(0, len(words) - 1))]
            new = draw(st.sampled_from(WORDS))
            lines[at] = lines[at][: word.start()] + new + lines[at][word.end() :]
        lines = lines or [""]
    return draw(damaged_bytes("\n".join(lines).encode("utf-8", "surrogatepass"), st.integers(0, 1)))


@st.composite
def damaged_bytes(draw, content: bytes, times=None) -> bytes:
    """Bytes changed, removed, repeated, or cut off."""
    data = bytearray(content)
    for _ in range(draw(times if times is not None else st.integers(1, 4))):
        if not data:
            break
        at, length = draw(st.integers(0, len(data) - 1)), draw(st.integers(1, 8))
        kind = draw(st.integers(0, 3))
        if kind == 0:
            data[at : at + length] = draw(st.binary(min_size=1, max_size=8))
        elif kind == 1:
            del data[at : at + length]
        elif kind == 2:
            data[at:at] = data[at : at + 50 * length]
        else:
            del data[at:]
    return bytes(data)


@st.composite
def damaged_json(draw, text: str) -> bytes:
    """A JSON record in which values are replaced, removed or repeated."""
    record = copy.deepcopy(json.loads(text))
    for _ in range(draw(st.integers(1, 3))):
        holder, key = record, None
        for _ in range(draw(st.integers(1, 6))):
            inner = holder if key is None else holder[key]
            keys = list(inner) if isinstance(inner, dict) else list(range(len(inner)))
            if not keys:
                break
            holder, key = inner, keys[draw(st.integers(0, len(keys) - 1))]
            if not isinstance(holder[key], dict | list):
                break
        if key is None:
            continue
        kind = draw(st.integers(0, 3))
        if kind == 0:
            del holder[key]
        elif kind == 1 and isinstance(holder, list):
            holder.append(holder[key])
        else:
            holder[key] = copy.deepcopy(draw(st.sampled_from(VALUES)))
    return json.dumps(record).encode()


@st.composite
def damaged_table(draw, path) -> pa.Table:
    """A table with cells replaced, rows repeated, removed or moved, columns removed."""
    table = pq.read_table(path)
    rows = table.to_pylist()
    for _ in range(draw(st.integers(1, 3))):
        if not rows:
            break
        at = draw(st.integers(0, len(rows) - 1))
        kind = draw(st.integers(0, 5))
        if kind == 0:
            del rows[at]
        elif kind == 1:
            rows.append(dict(rows[draw(st.integers(0, len(rows) - 1))]))
        else:
            field = table.schema.field(draw(st.integers(0, len(table.schema) - 1)))
            rows[at] = {**rows[at], field.name: draw(_cell(field.type))}
    changed = pa.Table.from_pylist(rows, schema=table.schema)
    if draw(st.integers(0, 9)) == 0:
        changed = changed.drop_columns([changed.column_names[draw(st.integers(0, 3))]])
    return changed


def _cell(kind: pa.DataType):
    if pa.types.is_boolean(kind):
        return st.sampled_from([None, True, False])
    if pa.types.is_integer(kind):
        return st.sampled_from([None, -1, 0, 1, 2**31, 2**62])
    if pa.types.is_floating(kind):
        return st.sampled_from([None, float("nan"), float("inf"), -50.0, 0.0, 1e30, 1e300])
    if pa.types.is_list(kind):
        return st.sampled_from(
            [None, [], [0.0], [float("nan")] * 9]
            if pa.types.is_floating(kind.value_type)
            else [None, []]
        )
    if not pa.types.is_string(kind):
        return st.none()
    return st.sampled_from([None, "", "x", "head", "\x1b[2J", "ä" * 999])
