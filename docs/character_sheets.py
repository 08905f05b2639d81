#!/usr/bin/env python3
"""Bakes characters in their liveliest clips, draws the worst frames of each beside skinning into docs/characters, and
writes the page that shows them, docs/characters/README.md, and its numbers, docs/characters/characters.json.

    python3 docs/character_sheets.py PROGRAM ASSETS [--only WORD] [--docs FOLDER]

ASSETS is a folder with the characters, which are not part of the project. Missing characters keep their earlier rows.
--only bakes only those whose file has the word in its name. Only Python's standard library is used.
"""
import json
import os
import re
import struct
import subprocess
import sys

import bakes
import figures

WIDE, TALL = ("288x240", "240x200", "192x160"), ("216x288", "180x240", "144x192")
# Name, file, endings of the clips' names, picture sizes to try, and camera options.
CHARACTERS = (
    ("Bull", "animals_pack_Bull.glb", ("Gallop_Jump", "Attack_Headbutt"), WIDE, ("--turn", "25")),
    ("Frog", "easy_enemies_Frog.glb", ("Attack", "Jump"), WIDE, ()),
    ("Trex", "dinosaurs_pack_Trex.glb", ("Attack", "Death"), WIDE, ("--turn", "25")),
    ("Fox", "animals_pack_Fox.glb", ("Gallop", "Gallop_Jump"), WIDE, ("--turn", "25")),
    ("Heavy man", "mh_fat.glb", ("jump", "biceps_curl"), TALL, ()),
    ("Heavier man, whose skin crosses itself", "mh_fat_selfint.glb", ("jump", "biceps_curl"), TALL, ()),
    ("Muscular man", "mh_muscle.glb", ("jump", "biceps_curl"), TALL, ()),
    ("Formal", "modular_women_Formal.glb", ("synthetic_jump",), TALL, ()),
    ("RobotExpressive", "RobotExpressive.glb", ("Dance", "Jump"), TALL, ()),
    ("CesiumMan", "CesiumMan.glb", ("",), TALL, ()),
)
MOST_BYTES = 250_000  # per picture

HEAD = """# Characters beside their skinning

`./do characters` writes this page and its pictures. It bakes each character of a folder of assets with nothing but its
file and a clip. Then it draws the six frames that look worst beside skinning alone, the worst first, no two of them
adjacent. Look is the score in [metrics.csv](../guide.md#how-it-looks): 1 is the limit, above which visible faults
appear. Lag is the largest RMS distance of a layer from skinning. Inverted is the largest number of tetrahedra inside
out in a frame, for flesh and for skinning alone.
"""
FOOT = """## Whose they are

[CesiumMan](https://github.com/KhronosGroup/glTF-Sample-Assets/tree/main/Models/CesiumMan) is (c) 2017 Cesium, under
[CC BY 4.0](https://creativecommons.org/licenses/by/4.0/); the pictures show it with changes: moved and relit by this
program. All others are CC0: Bull, Frog, Trex, Fox and Formal by Quaternius, RobotExpressive by Tomas Laulhe with
changes by Don McCurdy, and the men, which are built from MakeHuman's base mesh. The clips of the men and of Formal were
made for testing.
"""


def clips_of(path):
    """Names of a .glb's clips."""
    with open(path, "rb") as file:
        length = struct.unpack("<5I", file.read(20))[3]
        document = json.loads(file.read(length))
    return [animation.get("name", "") for animation in document.get("animations", [])]


def clip_index(clips, end):
    """The index of the clip with the shortest name that ends in `end`: files add prefixes to the names."""
    fitting = [k for k, name in enumerate(clips) if name.lower().endswith(end.lower())]
    if not fitting:
        raise LookupError(f"has no clip that ends in {end}; it has {', '.join(clips) or 'none'}")
    return min(fitting, key=lambda k: len(clips[k]))


def picture_name(name, clip):
    """bull-gallop-jump.png"""
    return re.sub(r"[^a-z0-9]+", "-", f"{name.split(',')[0]} {clip or 'clip'}".lower()).strip("-") + ".png"


def message_of(error, assets):
    """The program's last error message, without the path of the assets."""
    lines = [line for line in error.stderr.decode(errors="replace").splitlines() if "error:" in line]
    said = lines[-1].split("error:", 1)[1].strip() if lines else f"ended with status {error.returncode}"
    for folder in (os.path.abspath(assets), assets):
        said = said.replace(os.path.join(folder, ""), "")
    return said


def measured(bake):
    """The numbers of a row; null if the bake has none."""
    most = lambda name: max(bake.column(name)) if name in bake.metrics[0] else None
    lags = [most(name) for name in bake.metrics[0] if name.startswith("lag_")]
    over = sum(value > 1 for value in bake.column("look")) if "look" in bake.metrics[0] else None
    return {"frames": len(bake.metrics), "look": most("look"), "over": over, "lag": max(lags, default=None),
            "inverted": most("inverted"), "inverted_skinned": most("inverted_skinned")}


def draw(program, bake, path, sizes, options):
    """Draws the worst six frames, at the largest size within the limit on a picture's bytes."""
    for size in sizes:
        program.run("render", bake.folder, "-o", path, "--compare", "--worst", "6", "--follow", "--size", size,
                    "--overwrite", "-q", *options)
        if os.path.getsize(path) <= MOST_BYTES:
            return
    raise OSError(f"{path} has more than {MOST_BYTES} bytes at {sizes[-1]}")


def row_of(program, assets, character, end, folder):
    """Bakes and draws one clip of a character. Returns a dictionary for the page."""
    name, file, _, sizes, options = character
    row = {"name": name, "file": file, "clip": end}
    try:
        path = os.path.join(assets, file)
        clips = clips_of(path)
        index = clip_index(clips, end)
        row["clip"] = clips[index].split("|")[-1]
        picture = picture_name(name, row["clip"])
        baked = os.path.join(program.folder, picture[:-4])
        program.run("bake", path, "-o", baked, "--clip", str(index), "--overwrite", "-q")
        bake = bakes.Bake(baked)
        row |= measured(bake)
        draw(program, bake, os.path.join(folder, picture), sizes, options)
        row["picture"] = picture
    except subprocess.CalledProcessError as error:
        row["failed"] = message_of(error, assets)
    except LookupError as error:
        row["failed"] = str(error.args[0])
    return row


def number(value, digits):
    return "" if value is None else f"{value:.{digits}f}"


def cells(row):
    words = [row["name"], row["clip"]]
    if "failed" in row:
        return words + ["", "", "", "not baked: " + row["failed"].replace("|", "\\|").replace("\n", " "), ""]
    lag = None if row["lag"] is None else 1e3 * row["lag"]
    over = "" if row["over"] is None else f"{row['over']} of {row['frames']}"
    return words + [number(row["look"], 2), over, number(lag, 0),
                    f"{number(row['inverted'], 0)} / {number(row['inverted_skinned'], 0)}", f"[sheet]({row['picture']})"]


def page(rows):
    """The text of README.md."""
    lines = [HEAD, "| character | clip | look | frames over | lag, mm | inverted / skinned | |",
             "| --- | --- | --- | --- | --- | --- | --- |"]
    lines += ["| " + " | ".join(cells(row)) + " |" for row in rows]
    for row in rows:
        if "picture" in row:
            title = f"{row['name']}, {row['clip']}" if row["clip"] else row["name"]
            lines += ["", f"## {title}", "", f"![Worst frames of {title}]({row['picture']})"]
    return "\n".join(lines) + "\n\n" + FOOT


def make(program, assets, docs, only):
    folder = os.path.join(docs, "characters")
    os.makedirs(folder, exist_ok=True)
    record = os.path.join(folder, "characters.json")
    kept = []
    if os.path.exists(record):
        with open(record, encoding="utf-8") as file:
            kept = json.load(file)
    rows = []
    for character in CHARACTERS:
        file = character[1]
        if only.lower() not in file.lower() or not os.path.isfile(os.path.join(assets, file)):
            if only.lower() in file.lower():
                print(f"characters: {assets} has no {file}: its earlier rows stay", file=sys.stderr)
            rows += [row for row in kept if row["file"] == file]
            continue
        for end in character[2]:
            row = row_of(program, assets, character, end, folder)
            print(" ".join(filter(None, cells(row)[:6])))
            rows.append(row)
    shown = {row["picture"] for row in rows if "picture" in row}
    for name in os.listdir(folder):
        if name.endswith(".png") and name not in shown:
            os.remove(os.path.join(folder, name))
    figures.save(folder, "characters.json", json.dumps(rows, indent=1) + "\n")
    figures.save(folder, "README.md", page(rows))


def option(arguments, name, otherwise):
    if name not in arguments[:-1]:
        return otherwise
    at = arguments.index(name)
    value = arguments[at + 1]
    del arguments[at:at + 2]
    return value


def main(arguments):
    docs = option(arguments, "--docs", os.path.dirname(os.path.abspath(__file__)))
    only = option(arguments, "--only", "")
    if len(arguments) != 2 or arguments[0].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    if not os.path.isdir(arguments[1]):
        print(f"characters: {arguments[1]}: there is no such folder of characters", file=sys.stderr)
        return 3
    make(bakes.Program(arguments[0], "out/characters"), arguments[1], docs, only)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
