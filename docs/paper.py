#!/usr/bin/env python3
"""Bakes the paper's scenes, draws docs/figures, measures, and writes docs/paper.md and its numbers, docs/paper.json.

    python3 docs/paper.py PROGRAM [ASSETS]      do all of it; without the folder ASSETS, parts that need it stay as they are
    python3 docs/paper.py --check [PROGRAM]     check that the page follows from its numbers and its pictures exist;
                                                with a program, check that figures 2, 3, 6 and 7 still measure the same

Only Python's standard library is used. --docs FOLDER works in another folder than this file's.
"""
import json
import os
import re
import sys
import tempfile

import bakes
import characters
import figures
import page

FIGURES = {"2": figures.figure_2, "3": figures.figure_3, "6": figures.figure_6, "7": figures.figure_7, "8": figures.figure_8,
           "9": figures.figure_9, "crouch": figures.crouch, "10": figures.figure_10, "lag": lambda program, folder=None: figures.lag(program, "jump", folder)}
# Figures that take seconds.
CHEAP = ("2", "3", "6", "7")


def rounded(value):
    """Rounds to six digits: more than the page shows, fewer than the noise in a sum's last bits."""
    if isinstance(value, dict):
        return {key: rounded(v) for key, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [rounded(v) for v in value]
    return float(f"{value:.6g}") if isinstance(value, float) else value


def read(docs):
    with open(os.path.join(docs, "paper.json"), encoding="utf-8") as file:
        return json.load(file)


def write(docs, record):
    figures.save(docs, "paper.json", json.dumps(record, indent=1) + "\n")
    figures.save(docs, "paper.md", page.text(record))


def make(program, assets, docs):
    with tempfile.TemporaryDirectory(dir=docs) as pictures:
        record = measure(program, assets, docs, pictures)
        # All or nothing: pictures of this run with numbers of another would match no version of the program.
        os.makedirs(os.path.join(docs, "figures"), exist_ok=True)
        for name in sorted(os.listdir(pictures)):
            os.replace(os.path.join(pictures, name), os.path.join(docs, "figures", name))
    write(docs, record)


def measure(program, assets, docs, pictures):
    """Returns the contents of paper.json; draws into the folder `pictures`."""
    why = characters.missing(assets) if assets else "no folder of assets was given"
    kept = read(docs) if os.path.exists(os.path.join(docs, "paper.json")) else {}
    record = {"numbers": {}, "timings": {}, "assets": kept.get("assets"), "assets timings": kept.get("assets timings", {})}
    for name, figure in FIGURES.items():
        numbers, timings = figure(program, pictures)
        record["numbers"][name] = rounded(numbers)
        record["timings"][name] = rounded(timings)
    if why:
        print(f"paper: {why}: the pictures and numbers of characters that are not part of the project stay as they are", file=sys.stderr)
    else:
        record["assets"], record["assets timings"] = map(rounded, characters.measure(program, assets, pictures))
    return record


def check(program, docs):
    """Returns the faults, one line each."""
    record, wrong = read(docs), []
    with open(os.path.join(docs, "paper.md"), encoding="utf-8") as file:
        text = file.read()
    if text != page.text(record):
        wrong.append("paper.md is not what paper.json gives; run ./do paper")
    for picture in re.findall(r"!\[[^]]*\]\(([^)]*)\)", text):
        if not os.path.isfile(os.path.join(docs, picture)):
            wrong.append(f"paper.md shows {picture}, which is not there")
    for name in CHEAP if program else ():
        measured = json.loads(json.dumps(rounded(FIGURES[name](program)[0])))
        if measured != record["numbers"][name]:
            wrong.append(f"figure {name} measures {json.dumps(measured)}, and paper.json says "
                         f"{json.dumps(record['numbers'][name])}; run ./do paper")
    return wrong


def main(arguments):
    docs = os.path.dirname(os.path.abspath(__file__))
    if "--docs" in arguments[:-1]:
        at = arguments.index("--docs")
        docs = arguments[at + 1]
        del arguments[at:at + 2]
    if arguments[:1] == ["--check"]:
        with tempfile.TemporaryDirectory() as folder:
            wrong = check(bakes.Program(arguments[1], folder) if len(arguments) > 1 else None, docs)
        for line in wrong:
            print("paper: " + line, file=sys.stderr)
        return 1 if wrong else 0
    if not arguments or arguments[0].startswith("-"):
        print(__doc__, file=sys.stderr)
        return 2
    make(bakes.Program(arguments[0], "out/paper"), arguments[1] if len(arguments) > 1 else "", docs)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
