"""A binary glTF file in the making: arrays go in, one file comes out. Knows nothing of Blender."""

import json
import os
import struct

FLOAT, UNSIGNED_SHORT, UNSIGNED_INT = 5126, 5123, 5125
_BYTES = {FLOAT: 4, UNSIGNED_SHORT: 2, UNSIGNED_INT: 4}
_WIDTH = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Document:
    """glTF 2.0's own tables, and the bytes that they speak of."""

    def __init__(self):
        self.json = {"asset": {"version": "2.0", "generator": "fascicle for Blender"}, "scene": 0,
                     "scenes": [{"nodes": []}], "nodes": [], "meshes": [], "skins": [], "animations": [],
                     "accessors": [], "bufferViews": []}
        self._bytes = bytearray()

    def add(self, table, entry):
        """The entry's number."""
        self.json[table].append(entry)
        return len(self.json[table]) - 1

    def accessor(self, values, kind, component=FLOAT):
        """The number of an accessor of `values`, an array.array of that component; floats get their bounds."""
        width = _WIDTH[kind]
        view = self.add("bufferViews", {"buffer": 0, "byteOffset": len(self._bytes),
                                        "byteLength": len(values) * _BYTES[component]})
        self._bytes += values.tobytes()
        self._bytes += bytes(-len(self._bytes) % 4)
        entry = {"bufferView": view, "componentType": component, "type": kind, "count": len(values) // width}
        if component == FLOAT and kind in ("SCALAR", "VEC3") and len(values):
            entry["min"] = [min(values[i::width]) for i in range(width)]
            entry["max"] = [max(values[i::width]) for i in range(width)]
        return self.add("accessors", entry)

    def write(self, path):
        tables = {name: table for name, table in self.json.items() if table != []}
        tables["buffers"] = [{"byteLength": len(self._bytes)}]
        text = json.dumps(tables, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        with open(path + ".part", "wb") as file:
            file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(self._bytes)))
            file.write(struct.pack("<I4s", len(text), b"JSON") + text)
            file.write(struct.pack("<I4s", len(self._bytes), b"BIN\0") + self._bytes)
        os.replace(path + ".part", path)
