"""Malformed surfaces."""

import json
import math
import os
import random
import shutil
import struct
import sys
import time

from bakes import BAD_INPUT, DONE, FAILED, PROGRAM, hold, must_be_found
from refusals import controls, hold_refusal, in_pairs, measured

# Memory limit in bytes for a small file, three times the most measured, and for each byte of a larger one.
MOST_MEMORY, MEMORY_A_BYTE = 256 << 20, 1 << 10


def sphere(rings, radius=0.3):
    """(vertices, triangles) of a closed sphere."""
    vertices, triangles = [(0.0, radius, 0.0)], []
    for i in range(1, rings):
        for k in range(2 * rings):
            a, b = math.pi * i / rings, math.pi * k / rings
            vertices.append((radius * math.sin(a) * math.cos(b), radius * math.cos(a),
                             radius * math.sin(a) * math.sin(b)))
    vertices.append((0.0, -radius, 0.0))
    at = lambda i, k: 1 + (i - 1) * 2 * rings + k % (2 * rings)
    for k in range(2 * rings):
        triangles += [(0, at(1, k + 1), at(1, k)), (len(vertices) - 1, at(rings - 1, k), at(rings - 1, k + 1))]
        for i in range(1, rings - 1):
            triangles += [(at(i, k), at(i, k + 1), at(i + 1, k)), (at(i + 1, k), at(i, k + 1), at(i + 1, k + 1))]
    return vertices, triangles


def good(vertices, triangles):
    return vertices, triangles


def opened(vertices, triangles):
    keep = random.sample(triangles, len(triangles) - random.randint(0, len(triangles) // 2))
    return vertices, keep


def crossed(vertices, triangles):
    far = random.uniform(0.01, 0.5)
    n = len(vertices)
    return (vertices + [(x + far, y, z) for x, y, z in vertices],
            triangles + [(a + n, b + n, c + n) for a, b, c in triangles])


def flat(vertices, triangles):
    height = random.choice((0.0, 1e-30, 1e-9, 1e-4))
    return [(x, y * height, z) for x, y, z in vertices], triangles


def doubled(vertices, triangles):
    return vertices, triangles + random.choices(triangles, k=random.randint(1, len(triangles)))


def stacked(vertices, triangles):
    here = random.choice(vertices)
    return [here if random.random() < 0.3 else v for v in vertices], triangles


def odd_numbers(vertices, triangles):
    odd = lambda x: random.choice((math.nan, math.inf, -math.inf, 1e300, 1e39, -1e-320, 0.0, x)) \
        if random.random() < 0.02 else x
    return [tuple(odd(x) for x in v) for v in vertices], triangles


def scaled(vertices, triangles):
    factor = 10.0 ** random.uniform(-12, 12)
    return [tuple(factor * x for x in v) for v in vertices], triangles


def slivers(vertices, triangles):
    factor = 10.0 ** random.uniform(-7, -2)
    return [(x, y, z * factor) for x, y, z in vertices], triangles


def turned(vertices, triangles):
    return vertices, [t if random.random() < 0.5 else t[::-1] for t in triangles]


def beyond(vertices, triangles):
    pick = lambda: random.choice((0, 1, len(vertices), 2 ** 31 - 1, 2 ** 32, 10 ** 30))
    return vertices, [t if random.random() < 0.95 else (t[0], t[1], pick()) for t in triangles]


def torn(vertices, triangles):
    return [tuple(x + random.uniform(-0.1, 0.1) for x in v) for v in vertices], triangles


def few(vertices, triangles):
    count = random.randint(0, 3)
    return vertices, triangles[:count]


SURFACES = (opened, crossed, flat, doubled, stacked, odd_numbers, scaled, slivers, turned, beyond, torn, few)


def narrow(x):
    """Rounded to a 32-bit float."""
    try:
        return struct.unpack("<f", struct.pack("<f", x))[0]
    except OverflowError:
        return math.copysign(math.inf, x)


def obj(vertices, triangles):
    return ("".join("v %r %r %r\n" % v for v in vertices) +
            "".join("f %d %d %d\n" % tuple(i + 1 for i in t) for t in triangles)).encode()


def stl(vertices, triangles):
    """STL stores corners, not indices: an index out of range becomes NaN."""
    corner = lambda i: tuple(map(narrow, vertices[i])) if i < len(vertices) else (math.nan,) * 3
    return bytes(80) + struct.pack("<I", len(triangles)) + b"".join(
        struct.pack("<12fH", 0.0, 0.0, 0.0, *(x for i in t for x in corner(i)), 0) for t in triangles)


def ply(vertices, triangles):
    head = "ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty double x\nproperty double y\n" \
           "property double z\nelement face %d\nproperty list uchar uint vertex_indices\nend_header\n"
    return (head % (len(vertices), len(triangles))).encode() + \
        b"".join(struct.pack("<3d", *v) for v in vertices) + \
        b"".join(struct.pack("<B3I", 3, *(min(i, 2 ** 32 - 1) for i in t)) for t in triangles)


def glb(vertices, triangles):
    positions = [tuple(map(narrow, v)) for v in vertices]
    numbers = [[v[axis] for v in positions if math.isfinite(v[axis])] or [0.0] for axis in range(3)]
    data = b"".join(struct.pack("<3f", *v) for v in positions)
    indices = b"".join(struct.pack("<3I", *(min(i, 2 ** 32 - 1) for i in t)) for t in triangles)
    # A clip moves the mesh; otherwise it would not be a character.
    clip = struct.pack("<8f", 0.0, 0.2, 0.0, 0.0, 0.0, 0.0, 0.1, 0.0)
    parts = (data, indices, clip[:8], clip[8:])
    begins = [sum(map(len, parts[:i])) for i in range(len(parts))]
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
                        "samplers": [{"input": 2, "output": 3}]}],
        "buffers": [{"byteLength": sum(map(len, parts))}],
        "bufferViews": [{"buffer": 0, "byteOffset": at, "byteLength": len(part)} for at, part in zip(begins, parts)],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3",
                       "min": list(map(min, numbers)), "max": list(map(max, numbers))},
                      {"bufferView": 1, "componentType": 5125, "count": 3 * len(triangles), "type": "SCALAR"},
                      {"bufferView": 2, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0.0],
                       "max": [narrow(0.2)]},
                      {"bufferView": 3, "componentType": 5126, "count": 2, "type": "VEC3"}]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    data = b"".join(parts)
    return struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(data)) + \
        struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data


# A text format, and binary formats that can hold any bit pattern as a number.
FORMATS = (obj, stl, ply, glb)


def hold_memory(taken, size):
    """Limits the memory by the size of the file."""
    hold(taken <= MOST_MEMORY + MEMORY_A_BYTE * size, "%d MiB for a file of %d bytes" % (taken >> 20, size))


def try_surface(inputs):
    """(was baked, output, longest time in s, peak memory in bytes) of one surface."""
    k, kind, surface, environment, folder = inputs
    os.makedirs(folder)
    write = FORMATS[k % len(FORMATS)]
    path = os.path.join(folder, "%s-%d.%s" % (kind.__name__, k, write.__name__))
    content = write(*surface)
    with open(path, "wb") as file:
        file.write(content)
    # The default cage detail takes seconds, nearly all in the wrapping library, so only every tenth surface uses it.
    options = ("--resolution", "500", *(() if k % 10 == 9 else ("--cage-detail", "20")))
    longest, most, text, refusal = 0.0, 0, "", ""
    for command in (["inspect", path],
                    ["bake", path, "--end", "0.05", "--device", "cpu", "--threads", "1", "-o", folder + "/out"]):
        begin = time.monotonic()
        status, text, taken = measured([PROGRAM, *command, *options],
                                       {**environment, "FASCICLE_CACHE_DIR": os.path.join(folder, "cache")}, folder)
        longest, most = max(longest, time.monotonic() - begin), max(most, taken)
        is_whole = status == DONE
        hold(not (is_whole and refusal), "%s is baked, but inspect said: %s" % (os.path.basename(path), refusal))
        if not is_whole:
            refusal = text
            hold_refusal(status, text, (FAILED, BAD_INPUT), (os.path.basename(path), "mesh", "body"))
        hold_memory(taken, len(content))
    shutil.rmtree(folder)
    return is_whole, text, longest, most


def surfaces(bakes, count):
    """Generated surfaces go through `inspect` and `bake`, as .obj and as binary .stl, .ply and .glb. They are open,
    self-intersecting, flat, duplicated, torn, partly inside out, huge, tiny or made of slivers; their vertices
    coincide, are NaN, infinite or extreme, or are missing. Each is baked, or refused with one message that says what
    to do; what `inspect` refuses, `bake` refuses too. What takes more than 10 s must say that it is at work. Each
    process may use 256 MiB and 1 KiB for each byte of the file."""
    root = bakes[0].empty_folder()
    environment = bakes[0].environment()
    controls(environment, root)
    must_be_found(lambda: hold_memory(4 << 30, 2000), "4 GiB for 2 kB")
    # The mesher is a grandchild, so its memory must count too.
    greedy = "import subprocess, sys; subprocess.run([sys.executable, '-c', 'bytearray(300 << 20)'])"
    _, _, taken = measured([sys.executable, "-c", greedy], environment, root)
    hold(taken > 300 << 20, "the memory of a grandchild is not counted")

    kinds = random.sample(SURFACES, len(SURFACES))  # a few of them need not be always the same

    def drawn():
        for k in range(count):
            # The first surface of each format is valid: it would expose a program that refuses everything.
            kind = kinds[k // len(FORMATS) % len(kinds)] if k >= len(FORMATS) else good
            surface = kind(*sphere(random.randint(2, 9)))
            if k >= len(FORMATS) and random.random() < 0.2:
                surface = random.choice(SURFACES)(*surface) if surface[1] else surface
            yield k, kind, surface, environment, os.path.join(root, str(k))

    baked, longest, most = 0, 0.0, 0
    for k, (is_whole, text, seconds, taken) in enumerate(in_pairs(try_surface, drawn())):
        hold(is_whole or k >= len(FORMATS), "a sphere was refused: " + text)
        baked, longest, most = baked + is_whole, max(longest, seconds), max(most, taken)
    refused = count - baked
    hold(count < 50 or (baked and refused), "%d baked and %d refused: both must occur"
         % (baked, refused))
    shutil.rmtree(root)
    return "%d surfaces: %d baked, %d refused with one message; no crash, no hang; %.0f s and %d MiB at most" \
        % (count, baked, refused, longest, most >> 20)
