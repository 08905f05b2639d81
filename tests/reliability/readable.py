"""Checks that each output file is well-formed in its format, and that names in pages and scripts cannot become code."""

import ast
import csv
import json
import os
import re
import struct
import subprocess
import xml.etree.ElementTree

from bakes import hold

# Hostile names call this function if a page or script lets them become code.
CALLED = "escaped"
OBJ_WORDS = ("v", "vn", "vt", "f", "o", "g", "s", "usemtl", "mtllib")
MTL_WORDS = ("newmtl", "Ka", "Kd", "Ks", "Ke", "Ns", "Ni", "d", "Tr", "illum", "map_Kd", "Pr", "Pm",
             "map_Pr", "map_Pm", "map_d", "norm", "map_Ke")
USD_NAME = re.compile(r"[A-Za-z_]\w*$")


def lines_of(content, words, path):
    for line in content.decode().split("\n"):
        word = line.split(" ")[0]
        hold(not line.strip() or line.startswith("#") or word in words, "%s: unexpected line: %r" % (path, line[:80]))
        hold(word not in ("v", "vn", "vt") or all(map(is_number, line.split()[1:])), "%s: %r" % (path, line[:80]))


def is_number(text):
    return re.fullmatch(r"[-+]?\d+(\.\d*)?([eE][-+]?\d+)?", text) is not None


def obj(content, path):
    lines_of(content, OBJ_WORDS, path)


def mtl(content, path):
    lines_of(content, MTL_WORDS, path)


def usda(content, path):
    """Strings end on their line, brackets match, and prims have valid USD names."""
    text = content.decode()
    hold(text.startswith("#usda 1.0"), path + ": not USD")
    bare = re.sub(r'"""(?:[^"\\]|\\.|"(?!""))*"""|"(?:[^"\\\n]|\\.)*"|@[^@\n]*@|<[^>\n]*>|#[^\n]*', "", text)
    hold('"' not in bare and "@" not in bare, path + ": unterminated string")
    open_ones = []
    for mark in re.findall(r"[(){}\[\]]", bare):
        if mark in "({[":
            open_ones.append(mark)
        else:
            hold(open_ones and open_ones.pop() + mark in ("()", "{}", "[]"), path + ": unbalanced brackets")
    hold(not open_ones, path + ": unbalanced brackets")
    for name in re.findall(r'^\s*(?:def|over|class) \w* ?"([^\n]*?)"\s*[({]?$', text, re.MULTILINE):
        hold(USD_NAME.match(name), "%s: invalid prim name %r" % (path, name))


def pc2(content, path):
    hold(content.startswith(b"POINTCACHE2\0"), path + ": not a point cache")
    points, samples = struct.unpack_from("<i", content, 16)[0], struct.unpack_from("<i", content, 28)[0]
    hold(points > 0 and samples > 0 and len(content) == 32 + 12 * points * samples, path + ": wrong size")


def mdd(content, path):
    frames, points = struct.unpack_from(">2i", content)
    hold(frames > 0 and points > 0 and len(content) == 8 + 4 * frames + 12 * points * frames, path + ": wrong size")


def glb(content, path):
    magic, version, size = struct.unpack_from("<3I", content)
    hold((magic, version, size) == (0x46546C67, 2, len(content)), path + ": not glTF")
    json.loads(content[20:20 + struct.unpack_from("<I", content, 12)[0]])


def vtk(content, path):
    head, appended, _ = content.partition(b"<AppendedData")
    # VTK puts raw bytes after <AppendedData>, so the rest is not XML.
    xml.etree.ElementTree.fromstring(head + (b"</VTKFile>" if appended else b""))


def abc(content, path):
    """An Ogawa tree: every group and every piece of data lies within the file, and no group contains itself."""
    hold(content.startswith(b"Ogawa\xff\0\1"), path + ": not a complete Alembic file")

    def number(at):
        hold(at + 8 <= len(content), "%s: offset %d passes the end" % (path, at))
        return struct.unpack_from("<Q", content, at)[0]

    def walk(at, above):
        if at & 1 << 63:
            at &= (1 << 63) - 1
            hold(at == 0 or at + 8 + number(at) <= len(content), "%s: data at %d pass the end" % (path, at))
        elif at:
            hold(at not in above, "%s: the group at %d contains itself" % (path, at))
            for child in range(number(at)):
                walk(number(at + 8 + 8 * child), (*above, at))

    hold(number(8) != 0, path + ": an empty Alembic file")
    walk(number(8), ())


def comma_separated(content, path):
    rows = list(csv.reader(content.decode().splitlines()))
    hold(rows and len(set(map(len, rows))) == 1, path + ": rows of different lengths")
    for row in rows[1:]:
        hold(all(is_number(cell) for cell, column in zip(row, rows[0]) if column != "worst_joint"),
             "%s: not a row of numbers: %s" % (path, row))


def html(content, path):
    text = content.decode()
    for planted in ("<script>" + CALLED, "<img src=x", "<b>&amp;]]>"):
        hold(planted not in text, "%s: a name became markup: %s" % (path, planted))


def py(content, path):
    """It parses as Python, and no name became code."""
    tree = ast.parse(content, path)
    hold(not any(isinstance(node, ast.Name) and node.id == CALLED for node in ast.walk(tree)),
         path + ": a name became code")


def sh(content, path):
    done = subprocess.run(["bash", "-n", path], capture_output=True, text=True)
    hold(done.returncode == 0 and not done.stderr, "%s: %s" % (path, done.stderr))
    # Outside quotes, nothing of a name may remain.
    bare = re.sub(r"'[^']*'|\"(?:[^\"\\$`]|\\.|\$\{?\w+\}?)*\"|\\.", "", content.decode())
    hold(CALLED not in "\n".join(line for line in bare.split("\n") if not line.startswith("#")),
         path + ": a name became a command")


def as_json(content, path):
    json.loads(content)


# Our own formats, which `fascicle verify` reads, and textures, which are copied from the character.
UNREAD = (".fascicle", ".entry", ".png", "")
READERS = {".csv": comma_separated, ".obj": obj, ".mtl": mtl, ".usda": usda, ".pc2": pc2, ".mdd": mdd, ".glb": glb,
           ".vtu": vtk, ".vtp": vtk, ".pvd": vtk, ".abc": abc, ".html": html, ".py": py, ".sh": sh,
           ".sbatch": sh, ".json": as_json}


# The script that submits a batch to Slurm.
READERS_OF_NAMES = {"submit": sh}


def hold_readable(path):
    """Checks a file; returns False if its extension is one of UNREAD."""
    extension, name = os.path.splitext(path)[1], os.path.basename(path)
    if extension in UNREAD and name not in READERS_OF_NAMES:
        return False
    read = READERS_OF_NAMES.get(name, READERS.get(extension))
    hold(read, path + ": nothing reads files of this kind")
    with open(path, "rb") as file:
        content = file.read()
    try:
        read(content, path)
    except (ValueError, SyntaxError, struct.error, xml.etree.ElementTree.ParseError) as error:
        hold(False, "%s: %s" % (path, error))
    return True
