"""Writes a glTF character with any number of joints and clips: a snake with one joint per ring."""

import base64
import json
import math
import struct

RING, STEP, RADIUS = 8, 0.03, 0.06  # vertices per ring, m between joints, m
FLOAT, UNSIGNED_SHORT, UNSIGNED_INT = 5126, 5123, 5125


class Buffer:
    """Accessors of one buffer, in the order of their add()."""

    def __init__(self):
        self.bytes, self.views, self.accessors = b"", [], []

    def add(self, code, component, kind, rows, **more):
        flat = [x for row in rows for x in row]
        content = struct.pack("<%d%s" % (len(flat), code), *flat)
        self.views.append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(content)})
        self.accessors.append({"bufferView": len(self.views) - 1, "componentType": component, "type": kind,
                               "count": len(rows), **more})
        self.bytes += content + b"\0" * (-len(content) % 4)
        return len(self.accessors) - 1


def snake(joints):
    """(vertices, triangles, joint of each vertex) of a closed snake."""
    vertices, owner, triangles = [(0.0, -STEP / 2, 0.0)], [0], []
    for i in range(joints):
        for k in range(RING):
            a = 2 * math.pi * k / RING
            vertices.append((RADIUS * math.cos(a), STEP * i, RADIUS * math.sin(a)))
            owner.append(i)
    vertices.append((0.0, STEP * (joints - 0.5), 0.0))
    owner.append(joints - 1)
    at = lambda i, k: 1 + i * RING + k % RING
    for k in range(RING):
        triangles += [(0, at(0, k), at(0, k + 1)), (len(vertices) - 1, at(joints - 1, k + 1), at(joints - 1, k))]
        for i in range(joints - 1):
            triangles += [(at(i, k), at(i + 1, k), at(i, k + 1)), (at(i, k + 1), at(i + 1, k), at(i + 1, k + 1))]
    return vertices, triangles, owner


def write(path, joints, clips):
    """Each clip turns one joint there and back in 0.05 s."""
    vertices, triangles, owner = snake(joints)
    buffer = Buffer()
    position = buffer.add("f", FLOAT, "VEC3", vertices, min=[min(v[a] for v in vertices) for a in range(3)],
                          max=[max(v[a] for v in vertices) for a in range(3)])
    of_joint = buffer.add("H", UNSIGNED_SHORT, "VEC4", [(j, 0, 0, 0) for j in owner])
    weights = buffer.add("f", FLOAT, "VEC4", [(1.0, 0.0, 0.0, 0.0)] * len(owner))
    indices = buffer.add("I", UNSIGNED_INT, "SCALAR", [(v,) for t in triangles for v in t])
    inverse = buffer.add("f", FLOAT, "MAT4", [(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0,
                                               -STEP * i, 0.0, 1.0) for i in range(joints)])
    times = buffer.add("f", FLOAT, "SCALAR", [(0.0,), (0.025,), (0.05,)], min=[0.0], max=[0.05])
    nodes = [{"name": "joint %d" % i, "translation": [0.0, STEP if i else 0.0, 0.0],
              **({"children": [i + 1]} if i + 1 < joints else {})} for i in range(joints)]
    nodes.append({"name": "snake", "mesh": 0, "skin": 0})
    animations = []
    for k in range(clips):
        half = 0.002 * (k + 1)
        turns = buffer.add("f", FLOAT, "VEC4", [(0.0, 0.0, 0.0, 1.0), (math.sin(half), 0.0, 0.0, math.cos(half)),
                                                (0.0, 0.0, 0.0, 1.0)])
        animations.append({"name": "clip %d" % k, "samplers": [{"input": times, "output": turns}],
                           "channels": [{"sampler": 0, "target": {"node": joints * k // clips, "path": "rotation"}}]})
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, joints]}], "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": {"POSITION": position, "JOINTS_0": of_joint, "WEIGHTS_0": weights},
                                    "indices": indices}]}],
        "skins": [{"joints": list(range(joints)), "inverseBindMatrices": inverse}], "animations": animations,
        "accessors": buffer.accessors, "bufferViews": buffer.views,
        "buffers": [{"byteLength": len(buffer.bytes), "uri": "data:application/octet-stream;base64," +
                     base64.b64encode(buffer.bytes).decode()}]}
    with open(path, "w") as file:
        json.dump(document, file)
