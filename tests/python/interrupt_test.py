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


# A daemon thread is at work when the program ends: in a bake that tells its progress, in one that tells nothing, in a
# solver, in a callback that takes its time, and in a callback that uses a solver.
DAEMON = """
import atexit, json, os, sys, threading, time
way, folder = sys.argv[1:]
# Handlers run in reverse order: this one after the module's own, which waits for the work to end.
@atexit.register
def say_how_it_ended():
    if os.path.exists(folder):
        print(json.load(open(folder + "/manifest.json"))["status"])
import fascicle
at_work = threading.Event()
def solver():
    model = fascicle.Model(fascicle.Scene("bar-layers-i", end=100), cache="")
    made = fascicle.Solver(model, fascicle.Device("cpu", 1))
    made.start_clip()
    return made
within = solver() if way == "within" else None
def told(phase, done, total):
    if phase == "frames":
        at_work.set()
        if way == "slow":
            time.sleep(0.2)
        if way == "within":
            for _ in range(20):
                within.step_clip()
def work():
    if way == "solver":
        alone = solver()
        at_work.set()
        while True:
            alone.step_clip()
    fascicle.bake("bar-layers-i", folder, device="cpu", threads=1, cache="", end=1000,
                  progress=None if way == "silent" else told)
threading.Thread(target=work, daemon=True).start()
if way == "silent":
    while not os.path.exists(folder + "/manifest.json"):
        time.sleep(0.01)
else:
    at_work.wait(60)
"""


class End(InFolder):
    def test_of_the_interpreter_ends_threads_at_work(self):
        for way in ("told", "silent", "solver", "slow", "within"):
            ran = subprocess.run([sys.executable, "-c", DAEMON, way, self.path(way)], capture_output=True, text=True,
                                 timeout=60)
            said = "" if way == "solver" else "interrupted\n"
            self.assertEqual((ran.returncode, ran.stdout, ran.stderr), (0, said, ""), way)

    def test_of_a_forked_worker_leaves_its_parents_solver_alone(self):
        program = """
import os, sys, time, fascicle
solver = fascicle.Solver(fascicle.Model(fascicle.Scene("bar-layers-i", end=1), cache=""), fascicle.Device("cpu", 3))
solver.start_clip()
solver.step_clip()
time.sleep(0.1)  # until the solver's threads sleep
child = os.fork()
if child == 0:
    try:
        solver.step_clip()
    except fascicle.BadArgument as error:
        assert "of which this is a fork" in str(error)
        sys.exit(7)  # ends the interpreter, which destroys the solver
    sys.exit(1)
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""
        ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
        self.assertEqual((ran.returncode, ran.stderr), (7, ""))


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
