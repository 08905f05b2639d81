"""Runs the suite of a preset's build by ctest, and counts what came of it."""

import os
import re
import subprocess
import tempfile
import time

import page


def counts(results):
    """{"tests", "failures", "skipped": how many} of the JUnit file that ctest has written."""
    with open(results, errors="replace") as file:
        head = re.search(r"<testsuite[^>]*>", file.read(), re.DOTALL).group()
    return {key: int(re.search(r'\b%s="(\d+)"' % key, head).group(1)) for key in ("tests", "failures", "skipped")}


def run(preset, arguments, environment=None):
    """The counts, and "seconds". What takes a second takes ten here, so a test has long."""
    begin = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="fascicle-suite-") as folder:
        results = os.path.join(folder, "results.xml")
        subprocess.run(["ctest", "--preset", preset, "--timeout", "3000", "-j", str(os.cpu_count()),
                        "--output-on-failure", "--output-junit", results, *arguments],
                       cwd=page.ROOT, env=environment, check=False)
        return {**counts(results), "seconds": time.monotonic() - begin}


def which(arguments):
    """The tests that ran, for a table's cell, which a bar would end."""
    return "`ctest %s`" % " ".join(arguments).replace("|", "\\|") if arguments else "all"
