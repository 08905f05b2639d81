"""What a program may do wrong raises an exception, and never ends the process."""

import contextlib
import io
import math
import os
import subprocess
import sys
import threading
import unittest

import numpy as np

import fascicle
from support import SMALL_BAR, InFolder

UNFINISHED = "has not finished"
PROPERTIES = [(kind, name) for kind in (fascicle.BakeResult, fascicle.Device, fascicle.Model, fascicle.Scene, fascicle.Solver)
              for name, value in sorted(vars(kind).items()) if isinstance(value, property)]


class Objects(InFolder):
    def raises_in_a_process(self, program):
        """Runs a program that once ended the process, in a process of its own."""
        ran = subprocess.run([sys.executable, "-c", "import fascicle\n" + program], capture_output=True, text=True, timeout=60)
        self.assertEqual(ran.returncode, 1, ran.stderr)
        self.assertRegex(ran.stderr, "(?m)^TypeError: ")

    def test_without_a_finished_init_are_refused(self):
        self.raises_in_a_process("fascicle.Solver(fascicle.Model.__new__(fascicle.Model))")
        self.assertGreater(len(PROPERTIES), 20)
        for kind, name in PROPERTIES:
            with self.assertRaisesRegex(TypeError, UNFINISHED, msg=f"{kind.__name__}.{name}"):
                getattr(kind.__new__(kind), name)
        for kind in {kind for kind, _ in PROPERTIES}:
            with self.assertRaisesRegex(TypeError, UNFINISHED):
                repr(kind.__new__(kind)) if kind is not fascicle.Solver else kind.__new__(kind).step_clip()
        model = fascicle.Model(fascicle.Scene.parse(SMALL_BAR), cache="")
        with self.assertRaisesRegex(TypeError, UNFINISHED):
            fascicle.Solver(model, fascicle.Device.__new__(fascicle.Device))
        with self.assertRaisesRegex(TypeError, UNFINISHED):
            fascicle.bake(fascicle.Scene.__new__(fascicle.Scene), self.path("a"))

    def test_none_is_no_self(self):
        self.raises_in_a_process("fascicle.Model.vertex_count.fget(None)")
        self.raises_in_a_process("fascicle.Solver.positions.fget(None)")
        for kind, name in PROPERTIES:
            for wrong in (None, 3):
                with self.assertRaises(TypeError, msg=f"{kind.__name__}.{name}"):
                    getattr(kind, name).fget(wrong)

    def test_of_a_subclass_are_refused_until_their_init_has_finished(self):
        seen = []

        class Body(fascicle.Model):
            def __init__(self, scene, progress):
                super().__init__(scene, cache="", progress=progress)

        class Watched(Body):
            def __init__(self, scene):
                super().__init__(scene, self.watch)

            def watch(self, *_):
                try:
                    seen.append(self.vertex_count)
                except TypeError as error:
                    seen.append(str(error))

        class Failing(fascicle.Model):
            def __init__(self, scene):
                try:
                    super().__init__(scene, cache="", progress=lambda *_: False)
                except fascicle.Cancelled:
                    seen.append(repr(self))

        scene = fascicle.Scene.parse(SMALL_BAR)
        body = Watched(scene)
        self.assertTrue(seen and all(UNFINISHED in str(text) for text in seen), seen)
        with self.assertRaisesRegex(TypeError, UNFINISHED):
            Failing(scene)
        # The control: afterwards a subclass is as good as its base, as a self and as an argument.
        self.assertEqual(body.vertex_count, 45)
        solver = fascicle.Solver(body, fascicle.Device("cpu"))
        solver.step_drive(h=0.01, decay=[1.0])

    def test_of_two_bases_are_whole_by_parts(self):
        seen = []

        class Both(fascicle.Scene, fascicle.Device):
            def __init__(self):
                fascicle.Device.__init__(self, "cpu")
                seen.append(self.is_exact)
                try:
                    self.fps
                except TypeError as error:
                    seen.append(str(error))
                fascicle.Scene.__init__(self, "arm")
        self.assertEqual(Both().fps, 60.0)
        self.assertTrue(seen[0])
        self.assertIn(UNFINISHED, seen[1])

    def test_are_made_once(self):
        # The inner call finishes first: it makes the model, and the outer one is refused.
        self.raises_in_a_process(f"""
scene = fascicle.Scene.parse('''{SMALL_BAR}''')
model = fascicle.Model.__new__(fascicle.Model)
inner = []
def again(*_):
    if not inner:
        inner.append(model.__init__(scene, cache=""))
try:
    model.__init__(scene, cache="", progress=again)
finally:
    assert inner == [None] and model.vertex_count == 45
""")
        # Another thread does the same while the first one waits in its callback.
        scene = fascicle.Scene.parse(SMALL_BAR)
        model = fascicle.Model.__new__(fascicle.Model)
        waits, goes_on = threading.Event(), threading.Event()
        errors = []

        def first():
            def wait(*_):
                waits.set()
                goes_on.wait(60)
            try:
                model.__init__(scene, cache="", progress=wait)
            except TypeError as error:
                errors.append(str(error))
        thread = threading.Thread(target=first)
        thread.start()
        waits.wait(60)
        model.__init__(scene, cache="")
        goes_on.set()
        thread.join()
        self.assertEqual(errors, ["__init__() ran twice at once"])
        self.assertEqual(model.vertex_count, 45)
        # One after the other, the second does nothing.
        solver = fascicle.Solver(model, fascicle.Device("cpu"))
        model.__init__(fascicle.Scene.parse(SMALL_BAR, set=["bar.vertices=[6, 3, 3]"]), cache="")
        self.assertEqual(model.vertex_count, 45)
        solver.__init__(model)
        scene.__init__("arm")
        self.assertEqual(scene.joint_names, [])


class Texts(InFolder):
    def test_with_nul_are_refused(self):
        scene = fascicle.Scene.parse(SMALL_BAR)
        arrays = fascicle.Model(scene, cache="").arrays
        for call in (lambda: fascicle.Scene("arm\0junk"), lambda: fascicle.Scene("arm", clip="0\0"),
                     lambda: fascicle.Scene.parse(SMALL_BAR + "\0[junk"), lambda: fascicle.Device("cpu\0junk"),
                     lambda: fascicle.bake(scene, self.path("a"), device="cpu\0", cache=""),
                     lambda: fascicle.bake(scene, self.path("a"), formats=["pc2\0"]),
                     lambda: fascicle.Model.of_arrays({**arrays, "layer.name": ["fl\0esh"]}),
                     lambda: fascicle.Model.of_arrays({**arrays, "layer.name\0": ["flesh"]})):
            with self.assertRaises((ValueError, TypeError)):
                call()
        with self.assertRaisesRegex(fascicle.BadArgument, "NUL"):
            fascicle.Scene.parse(SMALL_BAR + "\0[junk")

    def test_that_are_not_utf_8_come_back(self):
        strange = os.fsdecode(b"b\xff")
        with open(self.path(strange + ".toml"), "w") as file:
            file.write(SMALL_BAR)
        scene = fascicle.Scene(self.path(strange + ".toml"))
        self.assertEqual(scene.name, strange)
        self.assertIn("fascicle.Scene 'b", repr(scene))
        repr(scene).encode()
        arrays = fascicle.Model(fascicle.Scene.parse(SMALL_BAR), cache="").arrays
        copy = fascicle.Model.of_arrays({**arrays, "layer.name": [strange]})
        self.assertEqual(copy.arrays["layer.name"], [strange])
        with self.assertRaisesRegex(fascicle.BadInput, "clip"):
            fascicle.Scene("arm", clip=strange)
        with self.assertRaises(ValueError):
            fascicle.Scene("arm", clip="\ud800")


class Answers(InFolder):
    def test_of_progress_are_asked_for_their_truth(self):
        class Truth:
            def __init__(self, truth):
                self.truth = truth

            def __bool__(self):
                return self.truth() if callable(self.truth) else self.truth

        class Without:
            pass

        scene = fascicle.Scene.parse(SMALL_BAR)
        for answer in (None, True, 1, "yes", [0], np.True_, Truth(True), Without()):
            fascicle.Model(scene, cache="", progress=lambda *_: answer)
        for answer in (False, 0, "", [], np.False_, Truth(False)):
            with self.assertRaises(fascicle.Cancelled, msg=answer):
                fascicle.Model(scene, cache="", progress=lambda *_: answer)
        for answer, error in ((Truth(lambda: 1 / 0), ZeroDivisionError), (Truth(lambda: 7), TypeError),
                              (np.zeros(2), ValueError)):
            with self.assertRaises(error):
                fascicle.Model(scene, cache="", progress=lambda *_: answer)

    def test_true_is_a_bar_everywhere(self):
        scene = fascicle.Scene("arm", end=0.1, motion={"preroll": 0.1})
        said = io.StringIO()
        said.isatty = lambda: True
        with contextlib.redirect_stderr(said):
            model = fascicle.Model(scene, cache="", progress=True)
            fascicle.Solver(model, fascicle.Device("cpu")).start_clip(True)
        self.assertIn("building the body", said.getvalue())
        self.assertIn("before frame 0", said.getvalue())
        for line in said.getvalue().split("\n")[:-1]:
            self.assertTrue(line.startswith("\r"), line)
        self.assertEqual(said.getvalue().count("\n"), 2, "one line of the model, one of the lead-in")
        fascicle.Model(scene, cache="", progress=False)


class Exceptions(InFolder):
    def setUp(self):
        super().setUp()
        self.model = fascicle.Model(fascicle.Scene.parse(SMALL_BAR), cache="")

    def test_of_wrong_types_are_type_errors(self):
        arrays = self.model.arrays
        for wrong in ({**arrays, 3: arrays["mass"]}, {**arrays, "layer.name": [3]}, {**arrays, "layer.name": [None]},
                      {**arrays, "mass": object()}, {**arrays, "mass": [[1.0], 2.0]}):
            with self.assertRaises(TypeError):
                fascicle.Model.of_arrays(wrong)
        for wrong in ([3], [None], [b"scene.fps=30"], ["scene.fps=30", 3]):
            with self.assertRaisesRegex(TypeError, "set: "):
                fascicle.Scene.parse(SMALL_BAR, set=wrong)

    def test_that_numpy_raises_stay_as_they_are(self):
        class Raising:
            def __init__(self, error):
                self.error = error

            def __array__(self, *_, **__):
                raise self.error

        arrays = self.model.arrays
        solver = fascicle.Solver(self.model, fascicle.Device("cpu"))
        solver.start_pose()
        for error in (MemoryError, ZeroDivisionError, KeyboardInterrupt):
            with self.assertRaises(error):
                fascicle.Model.of_arrays({**arrays, "mass": Raising(error)})
            with self.assertRaises(error):
                solver.step_pose(Raising(error))
            with self.assertRaises(error):
                solver.step_drive(h=0.01, decay=Raising(error))
        for error in (TypeError, ValueError):
            with self.assertRaises(TypeError):
                solver.step_pose(Raising(error))
            with self.assertRaisesRegex(TypeError, "mass"):
                fascicle.Model.of_arrays({**arrays, "mass": Raising(error)})

    def test_a_dict_that_changes_meanwhile_is_taken_as_it_was(self):
        arrays = dict(self.model.arrays)

        class Emptying:
            def __init__(self, array):
                self.array = array

            def __array__(self, *_, **__):
                arrays.clear()
                return self.array

        first = next(name for name, array in arrays.items() if isinstance(array, np.ndarray))
        arrays[first] = Emptying(arrays[first])
        self.assertEqual(fascicle.Model.of_arrays(arrays).vertex_count, 45)

    def test_of_numbers_that_are_nan_name_them(self):
        with self.assertRaisesRegex(fascicle.BadArgument, "fps is NaN"):
            fascicle.Scene.parse(SMALL_BAR, fps=math.nan)
        with self.assertRaisesRegex(fascicle.BadArgument, "softness is NaN"):
            fascicle.Scene("arm", softness=math.nan)
        with self.assertRaisesRegex(fascicle.BadArgument, "glb_error is NaN"):
            fascicle.bake(fascicle.Scene.parse(SMALL_BAR), self.path("a"), device="cpu", cache="", glb_error=math.nan)
        with self.assertRaisesRegex(fascicle.BadArgument, "viscosity is NaN"):
            fascicle.Solver(self.model, fascicle.Device("cpu"), viscosity=math.nan)
        solver = fascicle.Solver(self.model, fascicle.Device("cpu"))
        solver.start_pose()
        with self.assertRaisesRegex(fascicle.BadArgument, "time is NaN"):
            solver.step_pose(time=math.nan)

    def test_of_too_many_substeps(self):
        solver = fascicle.Solver(self.model, fascicle.Device("cpu"))
        with self.assertRaisesRegex(fascicle.BadArgument, "drive.substeps is 1001"):
            solver.step_drive(h=0.01, substeps=1001, decay=[1.0])


def unaligned(array):
    """The same numbers, a byte further than a number may begin."""
    moved = np.ndarray(array.shape, array.dtype, bytearray(array.nbytes + 1), offset=1)
    moved[...] = array
    assert not moved.flags.aligned
    return moved


class Memory(InFolder):
    def test_that_is_not_aligned_is_copied_or_refused(self):
        scene = fascicle.Scene("arm", end=0.05)
        model = fascicle.Model(scene)
        solver = fascicle.Solver(model, fascicle.Device("cpu"))
        rest = solver.clip_pose(0)
        solver.start_pose(rest)
        solver.step_pose(rest)
        wanted = solver.position_hash
        solver.start_pose(unaligned(rest))
        solver.step_pose(unaligned(rest))
        self.assertEqual(solver.position_hash, wanted)
        with self.assertRaisesRegex(ValueError, "aligned"):
            solver.world_positions(unaligned(np.zeros((model.vertex_count, 3), np.float32)))
        arrays = model.arrays
        self.assertTrue(np.array_equal(
            fascicle.Model.of_arrays({**arrays, "mass": unaligned(arrays["mass"])}).arrays["mass"], arrays["mass"]))


if __name__ == "__main__":
    unittest.main()
