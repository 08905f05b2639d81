#!/usr/bin/env python3
"""Measures the cost of each quality and the distance of its skin from a run with many more substeps, for two rods and a
clip of each character. Writes docs/design/accuracy.md and its numbers, docs/design/accuracy.json.

    python3 docs/accuracy.py PROGRAM ASSETS [--only WORD] [--docs FOLDER]

ASSETS is a folder with the characters, which are not part of the project. Missing characters keep their earlier rows.
--only measures only those whose file or scene has the word in its name. Only Python's standard library is used.
"""
import json
import os
import subprocess
import sys

import bakes
import character_sheets
import figures
import page

RODS = ("rod-hang", "rod-cantilever")
ROD_FRAMES = 120

HEAD = """# What a quality costs, and how near it comes

Written by `./do accuracy` from the measurements of `fascicle validate SCENE --converged`: it steps the same motion in
each quality and in a reference with twice the substeps and iterations of the finest quality, all without viscosity.
Error is the root mean square distance of the skin from the reference, over all frames of the clip; worst is the largest
distance of one vertex in one frame. The reference has an error too, about a third of the one measured for `final`. Time
is the solver's time for the clip, relative to `normal`.
"""
FOOT = "[integrators.md](integrators.md#substeps-and-iterations) says how substeps and iterations are chosen.\n"


def measured(program, scene, name, clip, options):
    """Returns a dictionary for the page."""
    row = {"scene": scene, "name": name, "clip": clip}
    path = options.get("path", scene)
    try:
        said = program.run("validate", path, "--converged", "--json", "--devices", "cpu", "-q",
                           *options["arguments"])
        row |= {key: json.loads(said)[key] for key in ("frames", "extent_m", "reference", "qualities")}
    except subprocess.CalledProcessError as error:
        row["failed"] = character_sheets.message_of(error, os.path.dirname(path) or ".")
    return row


def cells(row):
    """A row of the table for each quality."""
    if "failed" in row:
        return [[row["name"], row["clip"], "", "", "", "", "not measured: " + row["failed"]]]
    usual = next(q["solver_seconds"] for q in row["qualities"] if q["quality"] == "normal")
    lines = []
    for quality in row["qualities"]:
        first = not lines
        lines.append([row["name"] if first else "", row["clip"] if first else "", quality["quality"],
                      f"{quality['substeps']} x {quality['iterations']}", f"{1e3 * quality['rms_m']:.2f}",
                      f"{100 * quality['rms_m'] / row['extent_m']:.3f} %", f"{1e3 * quality['largest_m']:.1f}",
                      f"{quality['solver_seconds'] / usual:.2f}"])
    return lines


def text_of(rows):
    head = ["scene or character", "clip", "quality", "substeps x iterations", "error, mm", "of the extent", "worst, mm", "time"]
    return "\n".join([HEAD, page.table(head, [line for row in rows for line in cells(row)]), FOOT])


def jobs(assets):
    """For each job: scene or file, its name, its clip, and how to run it (None if the file is missing)."""
    for rod in RODS:
        yield rod, rod, "", {"arguments": ["--frames", str(ROD_FRAMES)]}
    for name, file, ends, _, _ in character_sheets.CHARACTERS:
        path = os.path.join(assets, file)
        if not os.path.isfile(path):
            yield file, name, "", None
            continue
        clips = character_sheets.clips_of(path)
        index = character_sheets.clip_index(clips, ends[0])
        yield file, name, clips[index].split("|")[-1], {"path": path, "arguments": ["--clip", str(index)]}


def make(program, assets, docs, only):
    folder = os.path.join(docs, "design")
    record = os.path.join(folder, "accuracy.json")
    kept = []
    if os.path.exists(record):
        with open(record, encoding="utf-8") as file:
            kept = json.load(file)
    rows = []
    for scene, name, clip, way in jobs(assets):
        if way is None or only.lower() not in scene.lower():
            if way is None and only.lower() in scene.lower():
                print(f"accuracy: {assets} has no {scene}: its earlier rows stay", file=sys.stderr)
            rows += [row for row in kept if row["scene"] == scene]
            continue
        rows.append(measured(program, scene, name, clip, way))
        for line in cells(rows[-1]):
            print(" ".join(line))
    figures.save(folder, "accuracy.json", json.dumps(rows, indent=1) + "\n")
    figures.save(folder, "accuracy.md", text_of(rows))


def main(arguments):
    docs = character_sheets.option(arguments, "--docs", os.path.dirname(os.path.abspath(__file__)))
    only = character_sheets.option(arguments, "--only", "")
    if len(arguments) != 2 or arguments[0].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    if not os.path.isdir(arguments[1]):
        print(f"accuracy: {arguments[1]}: there is no such folder of characters", file=sys.stderr)
        return 3
    make(bakes.Program(arguments[0], "out/accuracy"), arguments[1], docs, only)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
