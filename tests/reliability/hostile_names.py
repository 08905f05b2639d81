"""Names that want to be a path, a command, an escape or a mark-up."""

import json
import os
import re
import shutil
import struct
import xml.etree.ElementTree

from bakes import BAD_INPUT, DONE, FAILED, PROGRAM, hold, must_be_found
from refusals import BAD_USAGE, ended, hold_refusal



NAMES = ("../../escaped", "/tmp/escaped", "a\nb", "a\x1b[31mb", "\u202eevil", "'; touch escaped; '", "$(touch escaped)",
         "\"quoted\"", "<b>&amp;]]>", "a" * 100000, "nul", "-rf", ".", "..", " ", "", "\ttab", "100%s%n", "{}", "\\x",
         "\u0085next", "name\r", "caf\u00e9", "\U0001f600", "`id`", "#{a}", "*")
FORMATS = "abc,glb,mdd,obj,pc2,usda,vtp,vtu"
# What a terminal obeys, and what turns the direction of a line.
OBEYED = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")


def named_character(name):
    """A glTF of one bone and one clip that all have this name: a box, skinned to it."""
    positions = [(x, y, z) for x in (-.1, .1) for y in (-.1, .1) for z in (-.1, .1)]
    faces = [0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3]
    parts = [b"".join(struct.pack("<3f", *p) for p in positions), struct.pack("<36H", *faces),
             struct.pack("<32B", *([0, 0, 0, 0] * 8)), struct.pack("<32f", *([1.0, 0, 0, 0] * 8)),
             struct.pack("<2f", 0.0, 0.2), struct.pack("<6f", 0, 0, 0, 0, 0.1, 0)]
    views, data = [], b""
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(part)})
        data += part + b"\0" * (-len(part) % 4)
    accessor = lambda view, kind, count, shape, **more: {"bufferView": view, "componentType": kind, "count": count,
                                                         "type": shape, **more}
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"name": name, "nodes": [0, 1]}],
        "nodes": [{"name": name, "mesh": 0, "skin": 0}, {"name": name}],
        "skins": [{"name": name, "joints": [1]}], "materials": [{"name": name}],
        "meshes": [{"name": name, "primitives": [{"attributes": {"POSITION": 0, "JOINTS_0": 2, "WEIGHTS_0": 3},
                                                  "indices": 1, "material": 0}]}],
        "animations": [{"name": name, "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}],
                        "samplers": [{"input": 4, "output": 5}]}],
        "buffers": [{"byteLength": len(data)}], "bufferViews": views,
        "accessors": [accessor(0, 5126, 8, "VEC3", min=[-.1] * 3, max=[.1] * 3), accessor(1, 5123, 36, "SCALAR"),
                      accessor(2, 5121, 8, "VEC4"), accessor(3, 5126, 8, "VEC4"),
                      accessor(4, 5126, 2, "SCALAR", min=[0.0], max=[0.2]), accessor(5, 5126, 2, "VEC3")]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def everything_below(folder):
    return {os.path.join(parent, name) for parent, folders, names in os.walk(folder) for name in (*folders, *names)}


def hold_harmless(text):
    found = OBEYED.search(text)
    hold(not found, "a terminal would obey: %r" % text[max(0, found.start() - 40):found.end() + 40] if found else "")


def hold_readable(folder):
    """What others parse is parsed: JSON, XML and the JSON in glTF; what they list holds no path that leads out."""
    for path in everything_below(folder):
        if path.endswith(".json"):
            with open(path) as file:
                json.load(file)
        elif path.endswith((".vtu", ".vtp", ".pvd")):
            with open(path, "rb") as file:
                head, appended, _ = file.read().partition(b"<AppendedData")
            # Raw bytes stand behind it, as VTK has it.
            xml.etree.ElementTree.fromstring(head + (b"</VTKFile>" if appended else b""))
        elif path.endswith(".glb"):
            with open(path, "rb") as file:
                content = file.read()
            json.loads(content[20:20 + struct.unpack_from("<I", content, 12)[0]])


def names(bakes, count):
    """Names with slashes, quotes, line ends, control and bidirectional characters, or 100 kB long, of everything that a
    character's file names: `inspect`, `bake` in every format, `report`, `view` and `batch --dry-run`."""
    must_be_found(lambda: hold_harmless("a\x1b[2J"), "an escape")
    baked = 0
    for k in range(count):
        name = NAMES[k % len(NAMES)]
        outer = bakes[0].empty_folder()
        root = os.path.join(outer, "a", "b")
        os.makedirs(root)
        environment = bakes[0].environment(FASCICLE_CACHE_DIR=os.path.join(root, "cache"), TMPDIR=root)
        with open(os.path.join(root, "named.glb"), "wb") as file:
            file.write(named_character(name))
        with open(os.path.join(root, "jobs.toml"), "w") as file:
            file.write("[job.%s]\nscene = %s\nclips = \"all\"\n" % (json.dumps(name[:200]), json.dumps("named.glb")))
        before = everything_below(outer)
        for command in (["inspect", "named.glb"],
                        ["bake", "named.glb", "--device", "cpu", "--end", "0.1", "-o", "out", "--format", FORMATS],
                        ["report", "out", "-o", "out/report.html"], ["view", "out", "-o", "out/view.html"],
                        ["batch", "jobs.toml", "--dry-run", "-o", "batch"]):
            status, text = ended([PROGRAM, *command], environment, root)
            hold_harmless(text)
            if status != DONE:
                hold_refusal(status, text, (FAILED, BAD_USAGE, BAD_INPUT))
            elif command[0] == "bake":
                baked += 1
                hold_readable(os.path.join(root, "out"))
        inside = tuple(os.path.join(root, folder) for folder in ("out", "cache", "batch"))
        strays = [path for path in everything_below(outer) - before if not path.startswith(inside)]
        hold(not strays, "%r: files outside the folder: %s" % (name[:40], ", ".join(strays)))
        hold(not os.path.exists("/tmp/escaped"), "%r: a file outside" % name[:40])
        shutil.rmtree(outer)
    hold(baked * 2 > count, "only %d of %d were baked" % (baked, count))
    return "%d characters, %d of them baked: no file outside, no escape reaches the terminal, every file is readable" \
        % (count, baked)
