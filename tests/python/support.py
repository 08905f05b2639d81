"""Shared by the package's tests: small scenes, folders, the program."""

import os
import re
import subprocess
import tempfile
import unittest

PROGRAM = os.environ["FASCICLE_PROGRAM"]
REPOSITORY = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

# 45 vertices that hang from a wall for 6 frames.
SMALL_BAR = """
[scene]
end = 0.1
[bar]
size = [0.4, 0.1, 0.1]
vertices = [5, 3, 3]
[layers.flesh]
alpha = 0.5
damping = 1.0
[pin.wall]
where = { below = { axis = "x", fraction = 0.0 } }
"""


class InFolder(unittest.TestCase):
    """Each test has its own folder, and no other cache."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="fascicle-python-")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        before = os.environ.get("FASCICLE_CACHE_DIR")
        os.environ["FASCICLE_CACHE_DIR"] = self.path("cache")
        self.addCleanup(lambda: os.environ.pop("FASCICLE_CACHE_DIR") if before is None
                        else os.environ.__setitem__("FASCICLE_CACHE_DIR", before))

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def program(self, *arguments):
        """Runs the program; returns its stdout and stderr."""
        ran = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, timeout=300)
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)
        return ran.stdout + ran.stderr

    def program_hash(self, *arguments):
        return re.search(r"position hash of the last frame: ([0-9a-f]{16})", self.program(*arguments)).group(1)
