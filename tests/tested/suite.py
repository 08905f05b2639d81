"""Runs a preset's test suite with ctest, and counts the results."""

import os
import re
import subprocess
import tempfile
import time

import page


def counts(results):
    """{"tests", "failures", "skipped": counts} from ctest's JUnit file."""
    with open(results, errors="replace") as file:
        head = re.search(r"<testsuite[^>]*>", file.read(), re.DOTALL).group()
    return {key: int(re.search(r'\b%s="(\d+)"' % key, head).group(1)) for key in ("tests", "failures", "skipped")}


def run(preset, arguments, environment=None):
    """The counts, and "seconds". Tests run about ten times slower here, so their timeout is long."""
    begin = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="fascicle-suite-") as folder:
        results = os.path.join(folder, "results.xml")
        subprocess.run(["ctest", "--preset", preset, "--timeout", "3000", "-j", str(os.cpu_count()),
                        "--output-on-failure", "--output-junit", results, *arguments],
                       cwd=page.ROOT, env=environment, check=False)
        return {**counts(results), "seconds": time.monotonic() - begin}


def names(preset):
    """The suites of a build: the first parts of its tests' names, in ctest's order."""
    listed = subprocess.run(["ctest", "--preset", preset, "-N"], cwd=page.ROOT, capture_output=True, text=True,
                            check=True).stdout
    return list(dict.fromkeys(re.findall(r"^ *Test +#\d+: (\w+)\.", listed, re.MULTILINE)))


def which(arguments):
    """The tests that ran, for a table cell, in which `|` must be escaped."""
    return "`ctest %s`" % " ".join(arguments).replace("|", "\\|") if arguments else "all"
