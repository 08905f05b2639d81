"""What a program may do wrong raises an exception, and never ends the process."""

import subprocess
import sys
import threading
import unittest

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


if __name__ == "__main__":
    unittest.main()
