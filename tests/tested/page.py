"""docs/tests.md: the quality of the tests. Each command updates its own figures and keeps the others."""

import json
import os
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
FIGURES = os.path.join(ROOT, "docs", "tests.json")
FILE = os.path.join(ROOT, "docs", "tests.md")
SANITIZERS = ("asan", "tsan")

PAGE = """# What the tests are worth

A passing test says little until one knows what it would have caught. Three commands measure that: whether the suite is
clean under sanitizers, which lines it runs, and whether it notices planted faults. `./do coverage --write` updates its
part of this page, and the others theirs with the same option.

## Sanitizers

`./do sanitize` builds the preset `asan` (addresses, leaks, undefined behaviour), and `./do sanitize tsan` the preset
`tsan` (threads), with all assertions and the checks of the standard library, and runs the suite. It leaves out
`exactness`, which examines the release build, and `reliability`, which preloads a library that would bypass the
sanitizers. The mesher, the converter and the Python module are built without: a sanitizer needs terabytes of address
space, which their sandbox limits, and the interpreter must be started with it. Reports are counted from the sanitizers'
own log files, for every other process that a test starts, so a test that expects a failure cannot hide one. Undefined
behaviour ends a process with SIGABRT, which no test expects. First, a planted flaw of each kind must be reported, and
the programs must have been built with the sanitizer. CI runs no sanitizer: the builds alone take longer than it may.

%(sanitizers)s
## Coverage

`./do coverage` builds the preset `coverage`, runs the suite, and counts lines and branches with gcov and gcovr.
Branches that only an exception takes are left out. So are the mesher and the converter, whose sandbox does not let them
write counts, and the source that holds only toml++. At least 90 %% of the lines must run. First, a program with an
unused function must be counted as such.

%(coverage)s
## Planted faults

`./do mutants` makes one small change at a time to the kernels, the solver, the build, the cache and the code that
resumes bakes: it swaps a comparison, a sign or a bound, or leaves out a statement. Lines that contain text and lines
that throw are left alone. It builds, and runs the tests of that room until one fails. Before that, the tests must pass
on the unchanged sources. Some changes do not alter any result, such as whether memory is read ahead of its use; each is
listed with its reason in `tests/mutants/living.txt`.

Where a fault survived, we added a test, and planted the same faults again (`FASCICLE_SEED`): "found at first" counts
those found before that, which is the fair measure for a fault that nobody has tried.

%(mutants)s"""


def table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "".join("| %s |\n" % " | ".join(str(cell) for cell in line) for line in lines)


def share(part, whole):
    return "%.1f %%" % (100.0 * part / whole) if whole else "-"


def time_text(seconds):
    return "%.0f s" % seconds if seconds < 100 else "%.0f min" % (seconds / 60)


def sanitizers_text(figures):
    tables = []
    for preset, ran in sorted(figures["presets"].items()):
        rows = [("`%s`" % name, one["tests"], one["skipped"], one["failed"], one["reports"], time_text(one["seconds"]),
                 one["commit"]) for name, one in sorted(ran.items())]
        total = [sum(one[key] for one in ran.values()) for key in ("tests", "skipped", "failed", "reports", "seconds")]
        head = ("`%s`: suite" % preset, "tests", "skipped", "failed", "reports", "time", "commit")
        tables.append(table(head, [*rows, ("all of these", *total[:4], time_text(total[4]), "")]))
    return "\n".join(tables)


def coverage_text(figures):
    rows = [("`%s`" % room, lines, share(run, lines), share(taken, branches))
            for room, lines, run, branches, taken in figures["rooms"]]
    whole = [sum(row[k] for row in figures["rooms"]) for k in range(1, 5)]
    rows.append(("all", whole[0], share(whole[1], whole[0]), share(whole[3], whole[2])))
    ran = "%(tests)d tests ran, %(skipped)d were skipped and %(failures)d failed; tests chosen: %(which)s." % figures["ran"]
    return table(("room", "lines", "run", "branches taken"), rows) + "\n" + ran + " " + figures["about"]


def mutants_text(figures):
    rooms = figures["rooms"]
    keys = ("planted", "equivalent", "first", "found")
    counts = {"`%s`" % room: [one[key] for key in keys] + [one["seed"], one["commit"]] for room, one in rooms.items()}
    counts["all"] = [sum(one[key] for one in rooms.values()) for key in keys] + ["", ""]
    text = table(("room", "planted", "without effect", "found at first", "found now", "seed", "commit"), [
        (name, planted, equivalent, *("%d (%s)" % (found, share(found, planted - equivalent)) for found in (first, now)),
         seed, commit) for name, (planted, equivalent, first, now, seed, commit) in counts.items()])
    living = [row for one in rooms.values() for row in one["living"]]
    if living:
        head = ("where", "line", "changed to", "why no test notices")
        text += "\nThese faults went unnoticed:\n\n" + table(head, living)
    return text


TEXTS = {"sanitizers": sanitizers_text, "coverage": coverage_text, "mutants": mutants_text}


def commit(form="%h"):
    return subprocess.run(["git", "log", "-1", "--format=" + form], cwd=ROOT, capture_output=True, text=True,
                          check=True).stdout.strip()


def about():
    """The commit and machine of the figures, as a line below a table."""
    return "Commit %s, %d cores.\n" % (commit("%h of %as"), os.cpu_count())


def kept(section):
    """The section's last figures; empty if there are none."""
    return all_kept().get(section, {})


def all_kept():
    if not os.path.exists(FIGURES):
        return {}
    with open(FIGURES) as file:
        return json.load(file)


def put(section, figures):
    """Replaces the section's figures and rewrites the page."""
    sections = all_kept()
    sections[section] = {**figures, "about": about()}
    write(sections)


def write(sections):
    texts = {name: text(sections[name]) if name in sections else "Not measured yet.\n" for name, text in TEXTS.items()}
    for path, text in ((FIGURES, json.dumps(sections, indent=1) + "\n"), (FILE, PAGE % texts)):
        with open(path + ".new", "w") as file:
            file.write(text)
        os.rename(path + ".new", path)


if __name__ == "__main__":  # rewrites the page from the stored figures
    write(all_kept())
