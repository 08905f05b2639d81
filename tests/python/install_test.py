"""The installed package works from its prefix, also after the prefix was moved."""

import os
import subprocess
import sys
import unittest

from support import InFolder

PROGRAM = """
import sys, fascicle
print(fascicle.__file__)
print(fascicle.bake("arm", sys.argv[1], end=0.05, device="cpu").position_hash)
"""


class Install(InFolder):
    def test_serves_from_a_moved_prefix(self):
        ran = subprocess.run([os.environ["FASCICLE_CMAKE"], "--install", os.environ["FASCICLE_BINARY_DIR"], "--prefix",
                              self.path("prefix")], capture_output=True, text=True, timeout=300)
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)
        os.rename(self.path("prefix"), self.path("moved"))
        packages = self.path("moved", "lib", "python3", "dist-packages")
        # Nothing from the build folder can be found: neither its package nor its mesher.
        environment = {"PYTHONPATH": packages, "PATH": "/usr/bin:/bin", "FASCICLE_CACHE_DIR": self.path("cache")}
        ran = subprocess.run([sys.executable, "-B", "-c", PROGRAM, self.path("a")], capture_output=True, text=True,
                             timeout=300, env=environment, cwd=self.folder)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        file, position_hash = ran.stdout.split()
        self.assertTrue(file.startswith(packages), file)
        self.assertEqual(position_hash, self.program_hash("bake", "arm", "--end", "0.05", "--device", "cpu", "-o",
                                                          self.path("b")))


if __name__ == "__main__":
    unittest.main()
