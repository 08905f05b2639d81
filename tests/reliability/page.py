"""docs/reliability.md: what each row does and what its last run found. docs/reliability.json holds the results."""

import json
import os
import platform
import textwrap

import rows

DOCS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "docs")
PAGE_FILE = os.path.join(DOCS, "reliability.md")
FOUND_FILE = os.path.join(DOCS, "reliability.json")

PAGE = """# Reliability

Bakes run overnight, on farms, on files from strangers. `./do reliability` disturbs bakes in the ways listed below,
and checks that nothing is lost and nothing crashes. `./do reliability --write` writes this page; for single rows,
`./do reliability ROW... --write` does.

Most rows disturb three small bakes: a bar with one file per frame, a character in all formats with a cached body, and
a character whose body is built and settled in each run. Every file that has its final name afterwards is compared, byte
by byte, with that of an undisturbed bake. Then `--resume` completes the bake, from its checkpoint where there is one,
and all files are compared again.

Each row first proves that its checks can fail. It runs them against a careless program, or what one would leave: half
a file, a file that has its name before its bytes, a bake that starts over where it should resume, an ignored signal, a
hidden disk error, a missing sync, an abandoned child process, a socket, an error message that does not help, ten
seconds of silence, a slowing pace, or a leak. The checks must report it. A row is listed here only if everything it
checks held.

CI runs a short form of every row. Readers of files are also fuzzed: see [Fuzzing](fuzzing.md).

| row | disturbance | date | commit |
| --- | --- | --- | --- |
%(table)s
%(sections)s
## What is not covered

- Valgrind 3.19 knows no AVX-512, so `memory` has no result for that CPU level.
- The mesher is a separate program, and `memory` does not run it under Valgrind. `surfaces` does bound its memory.
- The validation layer does not see every missing barrier. A test leaves out each barrier of a solver in turn
  (`tests/gpu/barriers_test.cpp`) and detects all but one, which no result depends on: the two buffers of skinned
  positions count as one, so there is also a barrier between a write to one and a write to the other. Of the barriers
  that open a step, one of each kind must be detected.
- `values` leaves keys alone that name files, places, joints or layers.
- Mesa has a layer that sorts devices (`VK_LAYER_MESA_device_select`, 22.3.6). It crashes if one of its own queries
  fails, so `device` leaves it out.

## How to run it

`./do reliability` takes hours. `./do reliability ROW...` runs single rows, `./do reliability ROW... --write` also puts
their results on this page, and `./do reliability --share 0.1` does a tenth of each. `FASCICLE_SEED` repeats the random
choices of a run; its moments still depend on how fast the machine is. `FASCICLE_DEVICE=vulkan:0` lets the disturbed
bakes run on a GPU. Its results then stand beside those of the CPU.

Results without a GPU's name are from %(machine)s.
"""


def found_before():
    if not os.path.exists(FOUND_FILE):
        return {}
    with open(FOUND_FILE) as file:
        return json.load(file)


def duration(seconds):
    return "%.0f s" % seconds if seconds < 120 else "%.0f min" % (seconds / 60)


def paragraph(text):
    return "\n".join(textwrap.wrap(" ".join(text.split()), 120, break_long_words=False, break_on_hyphens=False)) + "\n"


def key(row, gpu):
    """Of a row's result: on the CPU, or on a GPU."""
    return "%s on %s" % (row, gpu) if gpu else row


def of_row(row, found):
    """{key: result} on all devices, the CPU first."""
    return {name: found[name] for name in sorted(found) if name == row.name or name.startswith(row.name + " on ")}


def section(row, found):
    parts = ["## %s\n" % row.name, paragraph(row.function.__doc__)]
    for name, one in of_row(row, found).items():
        _, _, gpu = name.partition(" on ")
        parts.append(paragraph("**%s:** %s (%s, seed %d%s)." % (
            "On " + gpu if gpu else "Result", one["figure"], duration(one["seconds"]), one["seed"],
            ", %s, commit %s" % (one["date"], one["commit"]) if gpu else "")))
    return "\n".join(parts)


def text_of(found):
    ran = [(row, next(iter(of.values()))) for row in rows.ROWS if (of := of_row(row, found))]
    lines = "".join("| [`%s`](#%s) | %s | %s | %s |\n" % (
        row.name, row.name, row.title, one["date"], one["commit"]) for row, one in ran)
    machines = sorted({one["machine"] for _, one in ran})
    return PAGE % {"table": lines, "sections": "\n".join(section(row, found) for row, _ in ran),
                   "machine": "; ".join(machines)}


def replace(path, text):
    with open(path + ".new", "w") as file:
        file.write(text)
    os.replace(path + ".new", path)


def machine():
    return "%s, %d cores" % (platform.machine(), os.cpu_count())


def write(found_now):
    """Rows that did not run keep their earlier results."""
    found = found_before()
    found.update(found_now)
    found = {name: one for row in rows.ROWS for name, one in of_row(row, found).items()}
    replace(FOUND_FILE, json.dumps(found, indent=1, ensure_ascii=False) + "\n")
    replace(PAGE_FILE, text_of(found))


def is_written():
    """Whether the page is up to date with docs/reliability.json."""
    with open(PAGE_FILE) as file:
        return file.read() == text_of(found_before())
