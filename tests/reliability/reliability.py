"""Disturbs bakes in every way of rows.py, and writes what came of it.

reliability.py [ROW...] [--short] [--share S] [--write]: FASCICLE_PROGRAM names the program,
FASCICLE_FAILING_CALLS the library that lets calls fail. --short: as often as CI has time for. --share: that share of
the times. --write: into the page in docs, where a row's line stays as it was unless it ran now."""

import argparse
import os
import platform
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import bakes
import rows

PAGE = """# Reliability

Bakes run overnight, on farms, on machines that stop. `./do reliability` disturbs small ones (a bar with a file a frame;
a character whose body is kept, in all formats; one whose body is built and comes to rest in every run) at random
moments and holds every file that has its final name against an undisturbed bake, byte by byte, then lets `--resume` go
on and compares again; it must go on from the checkpoint, where there is one. Then it gives the program what no tool
should write, lets bakes meet, takes its drivers away, lets their calls fail and makes its work grow. At last it lets
others watch bakes: Vulkan's validation layer and Valgrind. Each row first shows that its checks find a program out that
is not careful: half a file, another byte, a file that has its name before its bytes, a resume that begins anew, a
signal that is ignored or comes late, an error of the disk that is swallowed, a sync that is left out, a child that
lives, a socket, a message that names nothing or no way out, ten seconds at work without a word, a pace that slows down,
a fault planted for the layer, a leak. It writes this page. A short form of every row runs with the tests. What reads
files is fuzzed: [Fuzzing](fuzzing.md).

Valgrind 3.19 knows no AVX-512, so that level has no figure there. The mesher, a program of its own, is not watched.
What the layer does not look at, the tests do: they leave each barrier of a solver out alone
(`tests/gpu/barriers_test.cpp`).

| row | what is done | what came of it | time | seed | commit |
| --- | --- | --- | --- | --- | --- |
%s
The last run of each row on %s.

`./do reliability ROW... --write` runs single rows, and leaves the others' lines as they are; `./do reliability ROW...
--share 0.1` runs a tenth. `FASCICLE_SEED` repeats a run's moments, as far as a machine's own pace allows.
"""
PAGE_FILE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "docs", "reliability.md")


def write_page(lines):
    """`lines` by the names of rows. A row that did not run keeps its line."""
    kept = {}
    if os.path.exists(PAGE_FILE):
        with open(PAGE_FILE) as file:
            kept = {found.group(1): line for line in file if (found := re.match(r"\| `(\w+)` \|", line))}
    kept.update(lines)
    text = PAGE % ("".join(kept[row[0]] for row in rows.ROWS if row[0] in kept),
                   "%s, %d cores" % (platform.machine(), os.cpu_count()))
    with open(PAGE_FILE + ".new", "w") as file:
        file.write(text)
    os.replace(PAGE_FILE + ".new", PAGE_FILE)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("row", nargs="*", choices=[[], *(row[0] for row in rows.ROWS)])
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--share", type=float, default=1.0)
    parser.add_argument("--write", action="store_true")
    asked = parser.parse_args()
    seed = int(os.environ.get("FASCICLE_SEED", str(time.time_ns() % 1000000)))
    random.seed(seed)
    # A shell's background job ignores it, and so would all bakes.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=os.path.dirname(PAGE_FILE), text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False).stdout.strip() or "unknown"
    lines, is_broken = {}, True
    root = tempfile.mkdtemp(prefix="fascicle-reliability-")
    try:
        small = bakes.small_bakes()
        for bake in small:
            bake.prepare(root)
        broken = []
        for name, row, often, seldom in rows.ROWS:
            if asked.row and name not in asked.row:
                continue
            count = seldom if asked.short else max(1, round(often * asked.share))
            begin = time.monotonic()
            try:
                figure = row(small, count)
            except bakes.Broken as error:
                figure = "BROKEN: %s" % error
                broken.append(name)
            seconds = time.monotonic() - begin
            print("%-8s %s (%.0f s, seed %d)" % (name, figure, seconds, seed), flush=True)
            what = " ".join(row.__doc__.split())
            lines[name] = "| `%s` | %s | %s | %.0f s | %d | %s |\n" % (name, what, figure, seconds, seed, commit)
        is_broken = bool(broken)
    finally:
        if is_broken:
            print("kept for a look: " + root, file=sys.stderr)
        else:
            shutil.rmtree(root, ignore_errors=True)
    if asked.write and not is_broken:
        write_page(lines)
    return 1 if is_broken else 0


if __name__ == "__main__":
    sys.exit(main())
