"""Disturbs bakes in every way that rows.py lists, and reports the results.

reliability.py [ROW...] [--short] [--share S] [--write]: FASCICLE_PROGRAM names the program, FASCICLE_FAILING_CALLS the
library that makes calls fail, FASCICLE_FAULT_LAYER the Vulkan layer that does, FASCICLE_DEVICE the device of the
disturbed bakes (cpu). --short: as many runs as CI has time for. --share: that share of the runs. --write: puts the
results on the page in docs; rows that did not run keep theirs."""

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import bakes
import page
import rows

NOT_TESTED = "NOT TESTED"  # in the figure of a row that lacks something, such as strace


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("row", nargs="*", choices=[[], *(row.name for row in rows.ROWS)])
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--share", type=float, default=1.0)
    parser.add_argument("--write", action="store_true")
    asked = parser.parse_args()
    seed = int(os.environ.get("FASCICLE_SEED", str(time.time_ns() % 1000000)))
    random.seed(seed)
    # Background jobs of a shell ignore SIGINT, and their children inherit that.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=page.DOCS, text=True, stdout=subprocess.PIPE,
                            stderr=subprocess.DEVNULL, check=False).stdout.strip() or "unknown"
    found, is_broken, gpu = {}, True, bakes.gpu()
    others = [row.name for row in rows.ROWS if row.name in asked.row and not row.on_device]
    if gpu and others:
        parser.error("%s: these do not bake on FASCICLE_DEVICE" % ", ".join(others))
    root = tempfile.mkdtemp(prefix="fascicle-reliability-")
    try:
        small = bakes.small_bakes()
        for bake in small:
            bake.prepare(root)
        broken = []
        for row in rows.ROWS:
            if asked.row and row.name not in asked.row:
                continue
            if gpu and not row.on_device:
                continue
            count = row.seldom if asked.short else max(1, round(row.often * asked.share))
            begin = time.monotonic()
            try:
                figure = row.function(small, count)
            except bakes.Broken as error:
                figure = "BROKEN: %s" % error
                broken.append(row.name)
            seconds = time.monotonic() - begin
            print("%-8s %s (%.0f s, seed %d)" % (row.name, figure, seconds, seed), flush=True)
            found[page.key(row.name, gpu)] = {
                "figure": figure, "seconds": round(seconds), "seed": seed, "commit": commit,
                "date": time.strftime("%Y-%m-%d"), "machine": page.machine()}
        is_broken = bool(broken)
    finally:
        if is_broken:
            print("kept for a look: " + root, file=sys.stderr)
        else:
            shutil.rmtree(root, ignore_errors=True)
    # The page has no row of which a part could not be tested here.
    partial = sorted(name for name, row in found.items() if NOT_TESTED in row["figure"])
    if asked.write and not is_broken:
        page.write({name: row for name, row in found.items() if name not in partial})
        if partial:
            print("not written, for lack of something on this machine: " + ", ".join(partial), file=sys.stderr)
            is_broken = True
    if asked.short and not page.is_written():
        print("docs/reliability.md is not what page.py writes of docs/reliability.json", file=sys.stderr)
        is_broken = True
    return 1 if is_broken else 0


if __name__ == "__main__":
    sys.exit(main())
