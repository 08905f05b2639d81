"""Ctrl-C ends a bake within seconds, and its folder is marked as interrupted."""

import json
import os
import signal
import subprocess
import sys
import time
import unittest

from support import InFolder

# A thousand seconds of a bar: far more work than the test waits for.
PROGRAM = """
import sys, fascicle
def told(phase, done, total):
    if phase == "frames":
        print(done, flush=True)
fascicle.bake("bar-layers-i", sys.argv[1], device="cpu", threads=1, cache="", progress=told, end=1000)
"""


class Interrupt(InFolder):
    def test_ends_a_bake(self):
        bake = subprocess.Popen([sys.executable, "-c", PROGRAM, self.path("a")], stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True)
        self.addCleanup(bake.kill)
        for _ in range(3):
            self.assertTrue(bake.stdout.readline().strip())
        bake.send_signal(signal.SIGINT)
        began = time.monotonic()
        _, errors = bake.communicate(timeout=60)
        # A frame takes milliseconds; the rest allows for a busy machine.
        self.assertLess(time.monotonic() - began, 20)
        self.assertIn("KeyboardInterrupt", errors)
        self.assertEqual(bake.returncode, -signal.SIGINT)
        with open(self.path("a", "manifest.json")) as file:
            manifest = json.load(file)
        self.assertEqual(manifest["status"], "interrupted")
        # The control: an uninterrupted bake is marked as complete.
        subprocess.run([sys.executable, "-c", PROGRAM.replace("1000", "0.1"), self.path("b")], check=True,
                       capture_output=True, timeout=60)
        with open(self.path("b", "manifest.json")) as file:
            self.assertEqual(json.load(file)["status"], "complete")

    def test_ends_a_bake_that_nobody_watches(self):
        silent = PROGRAM.replace("progress=told", "log=None")
        bake = subprocess.Popen([sys.executable, "-c", silent, self.path("a")], stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True)
        self.addCleanup(bake.kill)
        deadline = time.monotonic() + 60
        while not os.path.exists(self.path("a", "manifest.json")) and time.monotonic() < deadline:
            time.sleep(0.05)
        bake.send_signal(signal.SIGINT)
        _, errors = bake.communicate(timeout=60)
        self.assertIn("KeyboardInterrupt", errors)
        with open(self.path("a", "manifest.json")) as file:
            self.assertEqual(json.load(file)["status"], "interrupted")


if __name__ == "__main__":
    unittest.main()
