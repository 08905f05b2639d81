"""fascicle.bake and its scenes: the same bits as the program, its messages, and that other threads run meanwhile."""

import ctypes
import io
import logging
import os
import threading
import time
import unittest

import fascicle
import fascicle._settings as settings
from support import SMALL_BAR, InFolder


class Bake(InFolder):
    def test_has_the_programs_hash(self):
        wanted = self.program_hash("bake", "bar-layers-i", "--end", "0.1", "--set", "layers.fat.alpha=0.2", "--device",
                                   "cpu", "-o", self.path("program"))
        result = fascicle.bake("bar-layers-i", self.path("python"), end=0.1, layers={"fat": {"alpha": 0.2}},
                               device="cpu", formats=["pc2"])
        self.assertEqual(result.position_hash, wanted)
        self.assertEqual(result.frames, 6)
        self.assertEqual(result.folder, self.path("python"))
        self.assertTrue(any(name.endswith(".pc2") for name in result.files), result.files)
        # The control: without the table it is a different scene.
        other = fascicle.bake("bar-layers-i", self.path("other"), end=0.1, device="cpu")
        self.assertNotEqual(other.position_hash, wanted)

    def test_takes_a_scene_and_names_the_folder(self):
        scene = fascicle.Scene.parse(SMALL_BAR)
        self.assertEqual((scene.frame_count, scene.fps, scene.joint_names), (6, 60.0, []))
        before = os.getcwd()
        os.chdir(self.folder)
        try:
            result = fascicle.bake(scene, cache="", device="cpu")
        finally:
            os.chdir(before)
        self.assertEqual(result.folder, os.path.join("out", scene.name))
        self.assertTrue(os.path.exists(self.path(result.folder, "manifest.json")))
        with self.assertRaisesRegex(TypeError, "end belongs to the scene"):
            fascicle.bake(scene, self.path("a"), end=0.1)

    def test_keeps_no_frames_where_none_are_wanted(self):
        scene = fascicle.Scene.parse(SMALL_BAR)
        fascicle.bake(scene, self.path("a"), device="cpu", cache="", formats="pc2", keep_frames=False)
        self.assertTrue(os.path.exists(self.path("a", "surface.pc2")))
        self.assertFalse(os.path.exists(self.path("a", "frames.fascicle")))
        with self.assertRaisesRegex(fascicle.BadArgument, "would leave no motion"):
            fascicle.bake(scene, self.path("b"), device="cpu", cache="", keep_frames=False)
        fascicle.bake(scene, self.path("b"), device="cpu", cache="", formats="none", keep_frames=False)
        self.assertTrue(os.path.exists(self.path("b", "metrics.csv")))

    def test_errors_carry_the_message_of_the_program(self):
        with self.assertRaises(fascicle.BadInput) as caught:
            fascicle.Scene("no-such-scene")
        self.assertIn("no such scene", str(caught.exception))
        self.assertEqual(caught.exception.status, 3)
        with self.assertRaisesRegex(fascicle.BadInput, "alpah") as caught:
            fascicle.Scene.parse(SMALL_BAR, layers={"flesh": {"alpah": 0.2}})
        self.assertIsInstance(caught.exception, ValueError)
        scene = fascicle.Scene.parse(SMALL_BAR)
        fascicle.bake(scene, self.path("a"), device="cpu", cache="")
        with self.assertRaises(fascicle.BadArgument):
            fascicle.bake(scene, self.path("a"), device="cpu", cache="")
        with self.assertRaises(fascicle.BadArgument):
            fascicle.bake(scene, self.path("b"), formats=["glbb"])
        with self.assertRaises(fascicle.Error):
            fascicle.Device("gpu")
        with self.assertRaisesRegex(TypeError, "formts"):
            fascicle.bake("bar-layers-i", self.path("b"), formts=["pc2"])

    def test_names_that_are_not_utf_8_are_told(self):
        strange = os.fsdecode(b"b\xff")
        with self.assertRaisesRegex(fascicle.BadInput, "does not exist"):
            fascicle.Scene(self.path(strange, "a.glb"))
        os.mkdir(self.path(strange))
        scene = fascicle.Scene.parse(SMALL_BAR)
        result = fascicle.bake(scene, self.path(strange, "out"), device="cpu", cache="", formats="pc2, mdd")
        self.assertEqual(result.folder, self.path(strange, "out"))
        self.assertTrue(all(os.path.exists(os.path.join(result.folder, file)) for file in result.files))
        self.assertIn("6 frames", repr(result))
        with self.assertRaisesRegex(fascicle.BadArgument, "out"):
            fascicle.bake(scene, self.path(strange, "out"), device="cpu", cache="")

    def test_settings_hold_no_nul(self):
        with self.assertRaisesRegex(ValueError, "NUL"):
            fascicle.Scene.parse(SMALL_BAR, set=["layers.flesh.alpha=0.2\0junk"])

    def test_every_kind_of_error_has_its_status(self):
        from fascicle._errors import error_of
        for status, kind in [(1, fascicle.Failed), (2, fascicle.BadArgument), (3, fascicle.BadInput),
                             (4, fascicle.NoSuchDevice), (5, fascicle.NotFinite), (7, fascicle.DeviceFailed), (75, fascicle.Cancelled)]:
            self.assertIs(type(error_of(status, "why")), kind)
            self.assertEqual(error_of(status, "why").status, status)

    def test_progress_is_told_and_cancels(self):
        scene = fascicle.Scene.parse(SMALL_BAR)
        told = []
        whole = fascicle.bake(scene, self.path("a"), device="cpu", cache="", progress=lambda *t: told.append(t))
        self.assertEqual(told[0], ("build", 0, 0))
        self.assertEqual([t for t in told if t[0] == "frames"], [("frames", k, 6) for k in range(1, 7)])
        with self.assertRaisesRegex(fascicle.Cancelled, "resume"):
            fascicle.bake(scene, self.path("b"), device="cpu", cache="", progress=lambda phase, done, total: done < 3)
        resumed = fascicle.bake(scene, self.path("b"), device="cpu", cache="", resume=True)
        self.assertEqual(resumed.position_hash, whole.position_hash)
        for callback in ("progress", "log"):
            with self.assertRaisesRegex(ZeroDivisionError, "mine"):
                def fail(*_):
                    raise ZeroDivisionError("mine")
                fascicle.bake(scene, self.path(callback), device="cpu", cache="", **{callback: fail})

    def test_says_what_it_finds_by_logging(self):
        with self.assertLogs("fascicle", logging.DEBUG) as said:
            fascicle.bake(fascicle.Scene.parse(SMALL_BAR), self.path("a"), device="cpu", cache="")
        self.assertTrue(said.output)

    def test_the_bar_is_plain_text(self):
        file = io.StringIO()
        fascicle.bake(fascicle.Scene.parse(SMALL_BAR), self.path("a"), device="cpu", cache="",
                      progress=fascicle.ProgressBar(file))
        lines = file.getvalue().splitlines()
        self.assertEqual(lines[0], "[" + "#" * 5 + "." * 25 + "] frame 1 of 6" + lines[0].partition("6")[2])
        self.assertEqual(lines[-1], "[" + "#" * 30 + "] frame 6 of 6")
        terminal = io.StringIO()
        terminal.isatty = lambda: True
        bar = fascicle.ProgressBar(terminal)
        for done in range(1, 7):
            bar("frames", done, 6)
        self.assertTrue(terminal.getvalue().startswith("\r["))
        self.assertTrue(terminal.getvalue().rstrip(" \n").endswith("frame 6 of 6"))
        self.assertTrue(terminal.getvalue().endswith("\n"))


def ticks_during(work):
    """How often another Python thread ran during `work`, at up to a thousand times a second."""
    ticks, done, begun = [0], threading.Event(), threading.Event()

    def tick():
        begun.set()
        while not done.is_set():
            ticks[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    begun.wait()
    before = ticks[0]
    work()
    during = ticks[0] - before
    done.set()
    thread.join()
    return during


class Lock(InFolder):
    def test_other_threads_run_during_a_bake(self):
        scene = fascicle.Scene("bar-layers-i", end=2)
        # Without callbacks into Python, other threads run only because the GIL is released. A bake takes a second; ten
        # ticks allow for a busy machine.
        enough = 10
        ticks = ticks_during(lambda: fascicle.bake(scene, self.path("a"), device="cpu", cache="", log=None))
        self.assertGreater(ticks, enough)
        # The control: a call that holds the GIL for a second lets no other thread run. Without the GIL there would be
        # hundreds of ticks; some may come before and after the call, if this thread has to wait for a processor.
        usleep = ctypes.PyDLL(None).usleep
        self.assertLess(ticks_during(lambda: usleep(999999)), 200)

    def test_a_scene_is_baked_by_two_threads_at_once(self):
        scene = fascicle.Scene.parse(SMALL_BAR)
        hashes = []
        threads = [threading.Thread(target=lambda name=name: hashes.append(
            fascicle.bake(scene, self.path(name), device="cpu", cache="").position_hash)) for name in "ab"]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(hashes), 2)
        self.assertEqual(hashes[0], hashes[1])


class Settings(unittest.TestCase):
    def test_values_are_toml(self):
        import tomllib
        import numpy as np
        values = {"a": True, "b": 3, "c": -0.1, "d": 'a "quoted"\n\\text', "e": [1, [2.5, "x"]], "f": 1e300,
                  "g": [{"h": 1, "i j": "k"}], "l": "déjà"}
        text = "\n".join(settings.settings(values, {}))
        self.assertEqual(tomllib.loads(text), values)
        self.assertEqual(settings.settings({"a": np.float64(0.25), "b": np.arange(3)}, {}), ["a=0.25", "b=[0, 1, 2]"])

    def test_paths_lead_through_tables(self):
        self.assertEqual(settings.settings(["a.b=1"], {"layers": {"fat": {"alpha": 0.2, "where": {}}}}),
                         ["a.b=1", "layers.fat.alpha=0.2", "layers.fat.where={}"])
        self.assertEqual(settings.settings({"a.b": 1, "c.d": {"e": 2}}, {}), ["a.b=1", "c.d.e=2"])
        for wrong in ({"a": {"b.c": 1}}, {"a=b": 1}, {"": 1}, {"a..b": 1}, {"a.": 1}, {1: 2}):
            with self.assertRaises(ValueError):
                settings.settings(wrong, {})
        with self.assertRaisesRegex(TypeError, "a.b"):
            settings.settings({"a": {"b": object()}}, {})


if __name__ == "__main__":
    unittest.main()
