"""Record sets and fields of croissant.json."""

from __future__ import annotations

from typing import Any

import pyarrow as pa

_SEQUENCE = r".*(seq_\d{6}).*"
_NUMBER = r".*?(\d{6})\.png"
# Readers of Croissant turn a picture into RGB of 8 bits: of these they get the file's name.
_SIXTEEN_BITS = ("depth", "disparity", "correspondence", "flow")


def record_set_of_table(
    name: str, source: str, description: str, schema: pa.Schema
) -> dict[str, Any]:
    """A record set of a table's columns and the row's sequence. source: id of the file set."""
    fields = [_of_path(f"{name}/sequence", source, _SEQUENCE, "sc:Text")]
    fields += [_of_column(f"{name}/{column.name}", source, column) for column in schema]
    return _record_set(name, description, fields)


def record_set_of_pictures(folder: str, description: str) -> dict[str, Any]:
    """A record set of the pictures of a folder, or of their file names."""
    source, name = f"pictures-{folder}", f"{folder}_pictures"
    fields = [
        _of_path(f"{name}/sequence", source, _SEQUENCE, "sc:Text"),
        # Files count from 1; `frame_index` of the tables is one less.
        _of_path(f"{name}/file_number", source, _NUMBER, "sc:Integer"),
    ]
    if folder.partition("_")[0] in _SIXTEEN_BITS:
        path = rf".*(seq_\d{{6}}/{folder}/\d{{6}}\.png)"
        fields.append(_of_path(f"{name}/file", source, path, "sc:Text"))
    else:
        origin = _origin(source, {"fileProperty": "content"})
        fields.append({**_named(f"{name}/picture"), "dataType": "sc:ImageObject", "source": origin})
    return _record_set(name, description, fields)


def _record_set(name: str, description: str, fields: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "@type": "cr:RecordSet",
        "@id": name,
        "name": name,
        "description": description,
        "field": fields,
    }


def _named(identity: str) -> dict[str, Any]:
    return {"@type": "cr:Field", "@id": identity, "name": identity.rpartition("/")[2]}


def _origin(source: str, extract: dict[str, str], **transform: str) -> dict[str, Any]:
    """Where a field comes from: a part of each file of a set, and its transform."""
    origin: dict[str, Any] = {"fileSet": {"@id": source}, "extract": extract}
    return {**origin, "transform": transform} if transform else origin


def _of_path(identity: str, source: str, regex: str, kind: str) -> dict[str, Any]:
    """A field that is a part of the file's path."""
    origin = _origin(source, {"fileProperty": "fullpath"}, regex=regex)
    return {**_named(identity), "dataType": kind, "source": origin}


def _of_column(identity: str, source: str, column: pa.Field) -> dict[str, Any]:
    """A field that is a column of a table; its entries are subfields where they are records."""
    field, kind, extract = _named(identity), column.type, {"column": column.name}
    if pa.types.is_list(kind):
        field["repeated"] = True
        kind = kind.value_type
    if pa.types.is_struct(kind):
        field["subField"] = [
            {
                **_named(f"{identity}/{part.name}"),
                "repeated": True,
                "dataType": _data_type(part.type),
                "source": _origin(source, extract, jsonPath=part.name),
            }
            for part in kind
        ]
        return field
    if pa.types.is_list(kind):  # points: the standard has lists of one level
        kind = kind.value_type
    return {**field, "dataType": _data_type(kind), "source": _origin(source, extract)}


def _data_type(kind: pa.DataType) -> str:
    if pa.types.is_boolean(kind):
        return "sc:Boolean"
    if pa.types.is_integer(kind):
        return "sc:Integer"
    return "sc:Float" if pa.types.is_floating(kind) else "sc:Text"
