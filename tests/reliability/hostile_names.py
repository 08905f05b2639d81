"""Names that could act as a path, a command, an escape sequence or markup."""

import json
import os
import random
import re
import shutil
import struct
import zlib

from bakes import BAD_INPUT, DONE, FAILED, PROGRAM, hold, must_be_found
from readable import hold_readable
from refusals import BAD_USAGE, ended, hold_refusal

NAMES = ("../../escaped", "/tmp/escaped", "a\nb", "a\x1b[31mb", "\u202eevil", "\u061c\u200eevil\u200f",
         "'; touch escaped; '", "$(touch escaped)", "\"quoted\"", "<b>&amp;]]>", "a" * 100000, "nul", "-rf", ".", "..",
         " ", "", "\ttab", "100%s%n", "{}", "\\x",
         "\u0085next", "name\r", "caf\u00e9", "\U0001f600", "`id`", "#{a}", "*",
         "</script><script>escaped()</script>", "\"><img src=x onerror=escaped()>", "a\"+escaped()+\"b",
         "a'+escaped()+'b",
         "a\"\"\"+escaped()+\"\"\"b", "\\\"+escaped()#", "a'$(escaped)'b", "a\nescaped()\n", "]]><b/>")
FORMATS = "abc,glb,mdd,obj,pc2,usda,vtp,vtu"
# Control characters that a terminal acts on, and characters that change text direction.
OBEYED = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]")


def picture():
    """A one-pixel PNG."""
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", 1, 1, 8, 2, 0, 0, 0)) + \
        chunk(b"IDAT", zlib.compress(b"\0\xff\x80\x40")) + chunk(b"IEND", b"")


def named_character(name):
    """A glTF box skinned to one bone, with a blend shape, a texture and two clips. Everything but the second clip has
    this name."""
    positions = [(x, y, z) for x in (-.1, .1) for y in (-.1, .1) for z in (-.1, .1)]
    faces = [0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3]
    parts = [b"".join(struct.pack("<3f", *p) for p in positions), struct.pack("<36H", *faces),
             struct.pack("<32B", *([0, 0, 0, 0] * 8)), struct.pack("<32f", *([1.0, 0, 0, 0] * 8)),
             struct.pack("<2f", 0.0, 0.2), struct.pack("<6f", 0, 0, 0, 0, 0.1, 0),
             struct.pack("<24f", *([0.0, 0.01, 0.0] * 8)),
             struct.pack("<2f", 0.0, 1.0), struct.pack("<16f", *(x for p in positions for x in p[:2])), picture()]
    views, data = [], b""
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(part)})
        data += part + b"\0" * (-len(part) % 4)
    accessor = lambda view, kind, count, shape, **more: {"bufferView": view, "componentType": kind, "count": count,
                                                         "type": shape, **more}
    move = {"channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}},
                         {"sampler": 1, "target": {"node": 0, "path": "weights"}}],
            "samplers": [{"input": 4, "output": 5}, {"input": 4, "output": 7}]}
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"name": name, "nodes": [0, 1]}],
        "nodes": [{"name": name, "mesh": 0, "skin": 0}, {"name": name}],
        "skins": [{"name": name, "joints": [1]}],
        "images": [{"name": name, "bufferView": 9, "mimeType": "image/png"}],
        "textures": [{"name": name, "source": 0}],
        "materials": [{"name": name, "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "meshes": [{"name": name, "extras": {"targetNames": [name]}, "primitives": [{
            "attributes": {"POSITION": 0, "JOINTS_0": 2, "WEIGHTS_0": 3, "TEXCOORD_0": 8}, "indices": 1, "material": 0,
            "targets": [{"POSITION": 6}]}]}],
        "animations": [{"name": name, **move}, {"name": "other", **move}],
        "buffers": [{"byteLength": len(data)}], "bufferViews": views,
        "accessors": [accessor(0, 5126, 8, "VEC3", min=[-.1] * 3, max=[.1] * 3), accessor(1, 5123, 36, "SCALAR"),
                      accessor(2, 5121, 8, "VEC4"), accessor(3, 5126, 8, "VEC4"),
                      accessor(4, 5126, 2, "SCALAR", min=[0.0], max=[0.2]), accessor(5, 5126, 2, "VEC3"),
                      accessor(6, 5126, 8, "VEC3", min=[0.0, 0.01, 0.0], max=[0.0, 0.01, 0.0]),
                      accessor(7, 5126, 2, "SCALAR"), accessor(8, 5126, 8, "VEC2")]}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def everything_below(folder):
    return {os.path.join(parent, name) for parent, folders, names in os.walk(folder) for name in (*folders, *names)}


def hold_harmless(text):
    found = OBEYED.search(text)
    hold(not found, "control characters in: %r" % text[max(0, found.start() - 40):found.end() + 40] if found else "")


def hold_no_strays(found, folders):
    """Each file is one of these or below one of them. `out-x` is not below `out`."""
    strays = [path for path in found if not any(path == folder or path.startswith(folder + "/") for folder in folders)]
    hold(not strays, "files outside the folder: " + ", ".join(sorted(strays)))


def ogawa(child):
    """An Alembic file of a group at byte 16 with this child, and of empty data at byte 32."""
    return b"Ogawa\xff\0\1" + struct.pack("<4Q", 16, 1, child, 0)


def controls_of_names(root):
    """Controls: files and messages of a program that does not escape names."""
    must_be_found(lambda: hold_harmless("a\x1b[2J"), "an escape sequence")
    hold_no_strays((os.path.join(root, "out", "a"), os.path.join(root, "out")), (os.path.join(root, "out"),))
    must_be_found(lambda: hold_no_strays((os.path.join(root, "out-x"),), (os.path.join(root, "out"),)),
                  "a sibling folder")
    for file_name, whole, broken in (
            ("a.obj", b"v 0 0 0\no a\n", b"o a\nescaped\n"), ("a.mtl", b"newmtl a\n", b"newmtl a\nb\n"),
            ("a.usda", b'#usda 1.0\ndef Mesh "a" (\n)\n{\n}\n', b'#usda 1.0\ndef Mesh "a b" (\n)\n{\n}\n'),
            ("a.usda", b'#usda 1.0\nstring a = "\\""\n', b'#usda 1.0\nstring a = "a"b"\n'),
            ("a.pc2", b"POINTCACHE2\0" + struct.pack("<2i2fi3f", 1, 1, 0, 1, 1, 0, 0, 0), b"POINTCACHE2\0" + bytes(20)),
            ("a.mdd", struct.pack(">2i4f", 1, 1, 0, 0, 0, 0), struct.pack(">2i", 1, 1)),
            ("a.csv", b"frame,x\n0,1.5e-3\n", b"frame,x,y\n0,1.5e-3\n"), ("a.csv", b"a\n1\n", b"a\nb\n"),
            ("a.abc", ogawa(1 << 63 | 32), ogawa(1 << 63 | 40)), ("a.abc", ogawa(0), ogawa(16)),
            ("a.json", b"{}", b"{"), ("a.vtu", b"<VTKFile a='b'/>", b"<VTKFile a='<'/>"),
            ("a.html", b"&lt;script>", b"<script>escaped()"), ("a.py", b"a = 'escaped()'\n", b"a = ''+escaped()+''\n"),
            ("a.py", b"a = 1\n", b"a = '\n"), ("a.sbatch", b"list='$(escaped)'\n", b"list=\"$(escaped)\"\n"),
            ("a.sbatch", b"echo 'a'\n", b"echo 'a\n"), ("submit", b"cd 'escaped'\n", b"cd escaped\n")):
        path = os.path.join(root, file_name)
        for content, is_whole in ((whole, True), (broken, False)):
            with open(path, "wb") as file:
                file.write(content)
            if is_whole:
                hold_readable(path)
            else:
                must_be_found(lambda: hold_readable(path), "%s: %r" % (file_name, content))


def commands_of(turn, name, root):
    """Writes the input files of a turn and returns its commands."""
    with open(os.path.join(root, "named.glb"), "wb") as file:
        file.write(named_character(name))
    file_name = "".join(c for c in name[:60] if c not in "/\0") + ".glb"
    shutil.copy(os.path.join(root, "named.glb"), os.path.join(root, file_name))
    # TOML has no surrogate escapes.
    quoted = lambda text: json.dumps(text, ensure_ascii=False)
    key = quoted(name[:200])
    with open(os.path.join(root, "keys.toml"), "w") as file:
        file.write("[character]\nfile = \"named.glb\"\n[layers.%s]\nalpha = 0.5\n[probe.%s]\n"
                   "where = { everywhere = true }\n" % (key, key))
    with open(os.path.join(root, "jobs.toml"), "w") as file:
        file.write("[job.%s]\nscene = \"named.glb\"\nclips = \"all\"\n" % key)
    with open(os.path.join(root, "clips.toml"), "w") as file:
        file.write('format = ["pc2"]\n[job.clips]\nset = ["scene.end=0.05"]\nscene = %s\nclips = "all"\n'
                   % quoted("./" + file_name))
    if turn == 0:
        return (["inspect", "named.glb"],
                ["bake", "named.glb", "--clips", "all", "--device", "cpu", "--end", "0.05", "-o", "out", "--format",
                 FORMATS], ["verify", ""], ["report", "", "-o", "report.html"], ["view", "", "-o", "view.html"],
                ["bake", "named.glb", "--clips", "all", "--device", "cpu", "--end", "0.1", "-o", "out", "--format",
                 FORMATS, "--resume"], ["verify", ""],
                ["batch", "jobs.toml", "--dry-run", "-o", "batch"])
    return (["bake", "keys.toml", "--device", "cpu", "--end", "0.05", "-o", "keys"],
            ["bake", "keys.toml", "--device", "cpu", "--end", "0.1", "-o", "keys", "--resume"], ["verify", ""],
            ["batch", "jobs.toml", "--device", "cpu", "-o", "batch"],
            ["batch", "clips.toml", "--device", "cpu", "-o", "out"],
            ["batch", "clips.toml", "--emit", "slurm", "-o", "farm"],
            ["batch", "clips.toml", "--emit", "openjd", "-o", "farm.json"])


def bakes_below(folder):
    return sorted(parent for parent, _, names in os.walk(folder) if "manifest.json" in names)


def names(bakes, count):
    """Hostile names hold slashes, quotes, line ends, markup, code, control or bidirectional characters, or are 100 kB
    long. They are given to everything that a character file names (joints, meshes, clips, blend shapes, materials,
    textures), to the file itself, and to jobs, layers and probes. The commands are `inspect`, `bake` of all clips in
    every format, `report` and `view` of each bake, `batch`, and `batch --emit` for both farms. Bakes are resumed with
    a later end, and `verify` accepts them before and after. Parsers read the files that they write, except our own
    formats and copied textures; the Blender script is compiled, and shell scripts go through `bash -n`."""
    controls_root = bakes[0].empty_folder()
    controls_of_names(controls_root)
    shutil.rmtree(controls_root)
    baked = parsed = 0
    in_order = random.sample(NAMES, len(NAMES))  # a few of them need not be always the same
    for k in range(count):
        name, turn = in_order[k // 2 % len(NAMES)], k % 2
        outer = bakes[0].empty_folder()
        root = os.path.join(outer, "a", "b")
        os.makedirs(root)
        environment = bakes[0].environment(FASCICLE_CACHE_DIR=os.path.join(root, "cache"), TMPDIR=root)
        commands = commands_of(turn, name, root)
        before = everything_below(outer)
        for command in commands:
            # These run once for each bake.
            folders = bakes_below(root) if command[0] in ("report", "view", "verify") else [""]
            for folder in folders:
                words = [os.path.join(folder, word) if word.endswith(".html") else word or folder for word in command]
                status, text = ended([PROGRAM, *words], environment, root)
                hold_harmless(text)
                hold(status == DONE or command[0] != "verify", "%r: %s" % (name[:40], text))
                if status != DONE:
                    hold_refusal(status, text, (FAILED, BAD_USAGE, BAD_INPUT))
        found = everything_below(outer) - before
        hold_no_strays(found, [os.path.join(root, folder) for folder in
                               ("out", "keys", "cache", "batch", "farm", "farm.json")])
        hold(not os.path.exists("/tmp/escaped"), "%r: a file outside the folder" % name[:40])
        baked += len(bakes_below(os.path.join(root, "out"))) > 1
        parsed += sum(hold_readable(path) for path in sorted(found) if os.path.isfile(path))
        shutil.rmtree(outer)
    # A few names may be refused, and they may be the only ones of a short run.
    hold(baked * 2 > count or count < len(NAMES), "all clips were baked for only %d of %d" % (baked, count))
    return "%d characters, of which %d baked both clips: no file outside the folder, no escape sequence on the " \
           "terminal; parsers read %d files" % (count, baked, parsed)
