"""Which lines and branches of the rooms a run of the tests has reached, room by room.

coverage.py BUILD [--write] [--missed]: BUILD was compiled with FASCICLE_COVERAGE and has run the tests. --write: into
docs/tests.md. --missed: also the files with the most lines that never ran."""

import argparse
import collections
import json
import os
import subprocess
import sys
import tempfile

import page

ROOMS = ("host/", "cpu_reference/", "gpu/")
LEAST = 0.9  # of the lines


def read(build):
    """[(file, lines, run, branches, taken)] as gcovr counts them."""
    with tempfile.TemporaryDirectory() as folder:
        summary_file = os.path.join(folder, "summary.json")
        filters = [part for room in ROOMS for part in ("--filter", room)]
        subprocess.run(["gcovr", "--root", page.ROOT, *filters, "--exclude-unreachable-branches",
                        "--exclude-throw-branches", "--gcov-ignore-parse-errors", "-j", str(os.cpu_count()),
                        "--json-summary", summary_file, build], check=True, cwd=page.ROOT,
                       stdout=subprocess.DEVNULL)
        with open(summary_file) as file:
            summary = json.load(file)
    return [(one["filename"], one["line_total"], one["line_covered"], one["branch_total"], one["branch_covered"])
            for one in summary["files"]]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--missed", action="store_true")
    asked = parser.parse_args()
    files = read(os.path.abspath(asked.build))
    rooms = collections.defaultdict(lambda: [0, 0, 0, 0])
    for name, *counts in files:
        room = "/".join(name.split("/")[:2]) if not name.startswith("gpu/") else "gpu"
        rooms[room] = [a + b for a, b in zip(rooms[room], counts)]
    rows = [[room, *counts] for room, counts in sorted(rooms.items())]
    lines, run = sum(row[1] for row in rows), sum(row[2] for row in rows)
    if not lines or not run:
        sys.exit("coverage: no line of the rooms has run; is %s built with FASCICLE_COVERAGE?" % asked.build)
    print(page.coverage_text({"rooms": rows, "about": ""}))
    if asked.missed:
        for name, total, covered, *_ in sorted(files, key=lambda one: one[2] - one[1])[:40]:
            print("%5d of %5d lines never ran: %s" % (total - covered, total, name))
    if asked.write:
        page.put("coverage", {"rooms": rows})
    if run < LEAST * lines:
        sys.exit("coverage: %s of the lines, below %s" % (page.share(run, lines), page.share(LEAST, 1)))


if __name__ == "__main__":
    main()
