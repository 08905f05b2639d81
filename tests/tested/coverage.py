"""Runs the test suite with preset `coverage`, and counts which lines and branches of the rooms it reaches.

coverage.py [--write] [--missed] [--again] [CTEST ARGUMENTS...]: build/coverage holds the build. First, a control
program must have its uncalled function reported as missed. --write: into docs/tests.md. --missed: also lists the files
with the most lines that never ran. --again: runs no tests and counts the last run."""

import argparse
import collections
import glob
import json
import os
import subprocess
import sys
import tempfile

import page
import suite

PRESET = "coverage"
BUILD = os.path.join(page.ROOT, "build", PRESET)
ROOMS = ("host/", "cpu_reference/", "gpu/")
# Sources that have no counts: their processes' sandboxes do not let them write any, or they hold only a library's code.
WITHOUT = ("host/mesher/", "host/convert/", "host/scene/toml.cpp")
LEAST = 0.9  # share of lines
PLANTED = """int reached(int a) { return a; }
int missed(int a)
{
    a = a + 1;
    return a;
}
int main(int argc, char**) { return argc > 99 ? missed(argc) : reached(0); }
"""


def read(root, build, rooms):
    """[(file, lines, lines run, branches, branches taken)] as gcovr counts them."""
    with tempfile.TemporaryDirectory() as folder:
        summary_file = os.path.join(folder, "summary.json")
        filters = [part for room in rooms for part in ("--filter", room)]
        done = subprocess.run(["gcovr", "--root", root, *filters, "--exclude-unreachable-branches",
                        "--exclude-throw-branches", "--gcov-ignore-parse-errors", "-j", str(os.cpu_count()),
                        "--json-summary", summary_file, build], check=False, cwd=root, stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE, text=True)
        # Its stderr is captured because it prints dozens of lines of warnings for each shader source generated in the
        # build folder.
        if done.returncode != 0:
            sys.exit("coverage: gcovr ended with %d: %s" % (done.returncode, done.stderr))
        with open(summary_file) as file:
            summary = json.load(file)
    return [(one["filename"], one["line_total"], one["line_covered"], one["branch_total"], one["branch_covered"])
            for one in summary["files"]]


def uncounted(files, sources):
    """The sources of the rooms that gcovr left out, as it does silently if it cannot read what the compiler wrote."""
    counted = {name for name, *_ in files}
    return [name for name in sources
            if name.startswith(ROOMS) and not name.startswith(WITHOUT) and name not in counted]


def remove_notes_without_object(build):
    """A build removes the objects of sources that are gone, but not the compiler's notes on their lines."""
    for path in glob.glob(os.path.join(build, "**", "*.gcno"), recursive=True):
        if not os.path.exists(path.removesuffix(".gcno") + ".o"):
            os.remove(path)


def sources_of_rooms():
    return subprocess.run(["git", "ls-files", "*.cpp"], cwd=page.ROOT, check=True, stdout=subprocess.PIPE,
                          text=True).stdout.split()


def control():
    """Of the five lines of PLANTED, the three of the uncalled function must be counted as missed; and a source that was
    left out must be found."""
    if uncounted([("gpu/a.cpp", 1, 1, 0, 0)], ["gpu/a.cpp", "gpu/b.cpp", "host/mesher/c.cpp"]) != ["gpu/b.cpp"]:
        sys.exit("coverage: a source without counts was not found")
    with tempfile.TemporaryDirectory(prefix="fascicle-coverage-") as folder:
        with open(os.path.join(folder, "planted.cpp"), "w") as file:
            file.write(PLANTED)
        subprocess.run(["g++", "-O0", "--coverage", "planted.cpp", "-o", "planted"], check=True, cwd=folder)
        subprocess.run([os.path.join(folder, "planted")], check=True, cwd=folder)
        counted = read(folder, folder, ["planted.cpp"])
    if [one[1:3] for one in counted] != [(5, 2)]:
        sys.exit("coverage: a line that nobody reaches was counted as run: %s" % counted)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--missed", action="store_true")
    parser.add_argument("--again", action="store_true")
    asked, arguments = parser.parse_known_args()
    control()
    ran = None
    if not asked.again:
        for path in glob.glob(os.path.join(BUILD, "**", "*.gcda"), recursive=True):
            os.remove(path)
        remove_notes_without_object(BUILD)
        ran = suite.run(PRESET, arguments)
    files = read(page.ROOT, BUILD, ROOMS)
    left_out = uncounted(files, sources_of_rooms())
    rooms = collections.defaultdict(lambda: [0, 0, 0, 0])
    for name, *counts in files:
        room = "/".join(name.split("/")[:2]) if not name.startswith("gpu/") else "gpu"
        rooms[room] = [a + b for a, b in zip(rooms[room], counts)]
    rows = [[room, *counts] for room, counts in sorted(rooms.items())]
    lines, run = sum(row[1] for row in rows), sum(row[2] for row in rows)
    if not lines or not run:
        sys.exit("coverage: no line of the rooms has run")
    figures = {"rooms": rows, "ran": {**ran, "which": suite.which(arguments)} if ran else page.kept("coverage")["ran"]}
    print(page.coverage_text({**figures, "about": ""}))
    if asked.missed:
        for name, total, covered, *_ in sorted(files, key=lambda one: one[2] - one[1])[:60]:
            print("%5d of %5d lines never ran: %s" % (total - covered, total, name))
    if asked.write and not left_out:
        page.put("coverage", figures)
    if left_out:
        print("coverage: gcovr counted nothing in %d sources: %s" % (len(left_out), ", ".join(left_out)),
              file=sys.stderr)
    if ran and ran["failures"]:
        sys.exit("coverage: %d tests failed" % ran["failures"])
    if left_out:
        sys.exit(1)
    if run < LEAST * lines:
        sys.exit("coverage: %s of the lines, below %s" % (page.share(run, lines), page.share(LEAST, 1)))


if __name__ == "__main__":
    main()
