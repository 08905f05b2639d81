"""Models and solvers from numpy: the same bits as the C++ wrapper, and no copies where none are promised."""

import logging
import os
import subprocess
import threading
import unittest

import numpy as np

import fascicle
from support import SMALL_BAR, InFolder


class SmallSolver(InFolder):
    def setUp(self):
        super().setUp()
        self.scene = fascicle.Scene.parse(SMALL_BAR)
        self.model = fascicle.Model(self.scene, cache="")
        self.solver = fascicle.Solver(self.model, fascicle.Device("cpu"))

    def test_steps_a_clip_as_a_bake_does(self):
        self.solver.start_clip()
        for _ in range(self.scene.frame_count):
            self.solver.step_clip()
        bake = fascicle.bake(self.scene, self.path("a"), device="cpu", cache="")
        self.assertEqual(self.solver.position_hash, bake.position_hash)
        self.assertEqual(self.solver.frame, 6)
        self.assertEqual(self.solver.device, fascicle.Device("cpu").text)

    def test_arrays_are_the_solvers_memory(self):
        self.solver.start_clip()
        self.solver.step_clip()
        positions, again = self.solver.positions, self.solver.positions
        self.assertEqual((positions.shape, positions.dtype), ((45, 3), np.float32))
        self.assertTrue(np.shares_memory(positions, again))
        self.assertFalse(positions.flags.owndata or positions.flags.writeable)
        self.assertFalse(np.shares_memory(positions, self.solver.velocities))
        self.assertEqual(self.solver.surface.shape, (self.model.surface_vertex_count, 3))
        # The control: world positions are a copy, and match the formula within float rounding.
        world = self.solver.world_positions()
        self.assertFalse(np.shares_memory(world, positions))
        wanted = self.solver.origin + self.solver.unit * positions.astype(np.float64)
        np.testing.assert_allclose(world, wanted, rtol=0, atol=1e-7)

    def test_does_not_go_on_while_its_memory_is_in_use(self):
        self.solver.start_clip()
        part = self.solver.positions[3:5, 1]
        for go_on in (self.solver.start_clip, self.solver.step_clip, self.solver.start_pose, self.solver.step_pose,
                      lambda: self.solver.load(self.solver.save()), lambda: self.solver.step_drive(h=0.01)):
            with self.assertRaisesRegex(BufferError, "1 arrays .*copies"):
                go_on()
        del part
        self.solver.step_clip()
        # An array keeps its solver alive.
        positions = self.solver.positions
        expected = positions.copy()
        del self.solver
        np.testing.assert_array_equal(positions, expected)

    def test_fills_an_array_that_is_given(self):
        self.solver.start_clip()
        out = np.empty((45, 3), np.float32)
        self.assertIs(self.solver.world_positions(out), out)
        np.testing.assert_array_equal(out, self.solver.world_positions())
        out.flags.writeable = False
        for wrong, why in [(np.empty((44, 3), np.float32), r"\(44, 3\); it must be \(45, 3\)"), (out, "read-only"),
                           (np.empty((45, 3)), "float32"), (np.empty((45, 6), np.float32)[:, ::2], "contiguous")]:
            with self.assertRaisesRegex(ValueError, why):
                self.solver.world_positions(wrong)

    def test_goes_on_from_saved_bytes(self):
        self.solver.start_clip()
        state = self.solver.save()
        self.solver.step_clip()
        wanted = self.solver.position_hash
        self.solver.load(state)
        self.solver.step_clip()
        self.assertEqual(self.solver.position_hash, wanted)
        with self.assertRaises(fascicle.BadInput):
            self.solver.load(state[:-1])

    def test_is_used_by_one_call_at_a_time(self):
        def from_inside(*_):
            with self.assertRaisesRegex(RuntimeError, "another call"):
                self.solver.step_clip()
            with self.assertRaisesRegex(RuntimeError, "another call"):
                self.solver.positions
            seen.append(True)
        seen = []
        scene = fascicle.Scene("arm", end=0.1, motion={"preroll": 0.1})
        self.solver = fascicle.Solver(fascicle.Model(scene, cache=""), fascicle.Device("cpu"))
        self.solver.start_clip(from_inside)
        self.assertTrue(seen)

    def test_a_start_is_cancelled(self):
        scene = fascicle.Scene("arm", end=0.1, motion={"preroll": 0.1})
        solver = fascicle.Solver(fascicle.Model(scene, cache=""), fascicle.Device("cpu"))
        with self.assertRaises(fascicle.Cancelled):
            solver.start_clip(lambda *_: False)

    def test_a_build_says_what_it_finds_by_logging(self):
        with self.assertLogs("fascicle", logging.DEBUG) as said:
            fascicle.Model(self.scene, cache="")
        self.assertTrue(said.output)
        with self.assertNoLogs("fascicle", logging.DEBUG):
            fascicle.Model(self.scene, cache="", log=None)

    def test_a_build_is_cancelled(self):
        with self.assertRaises(fascicle.Cancelled):
            fascicle.Model(self.scene, cache="", progress=lambda *_: False)
        told = []
        fascicle.Model(self.scene, cache="", progress=lambda *t: told.append(t))
        self.assertEqual(set(told), {("build", 0, 0)})

    def test_takes_rotation_iterations_and_viscosity(self):
        def hash_of(scene, **options):
            solver = fascicle.Solver(fascicle.Model(scene, cache=""), fascicle.Device("cpu"), **options)
            solver.start_clip()
            for _ in range(3):
                solver.step_clip()
            return solver.position_hash
        other = fascicle.Scene.parse(SMALL_BAR, set=["solver.rotation=mueller2016"])
        self.assertEqual(hash_of(self.scene, rotation="mueller2016"), hash_of(other))
        with self.assertRaisesRegex(fascicle.BadArgument, "polar"):
            hash_of(self.scene, rotation="polar")
        with self.assertRaises(fascicle.BadArgument):
            hash_of(self.scene, iterations=0)
        soft = fascicle.Scene.parse(SMALL_BAR, set=["layers.flesh={youngs_modulus=3e4}"])
        viscous = fascicle.Scene.parse(SMALL_BAR, set=["layers.flesh={youngs_modulus=3e4}", "solver.viscosity=0.003"])
        self.assertEqual(hash_of(soft, viscosity=0.003), hash_of(viscous))
        self.assertNotEqual(hash_of(soft, viscosity=0.003), hash_of(soft))

    def test_takes_no_joints_without_a_skeleton(self):
        self.solver.start_pose()
        self.solver.step_pose(time=0.5)
        self.solver.step_pose(np.empty((0, 4, 4)))
        self.assertEqual(self.solver.frame, 2)
        self.assertEqual(self.solver.clip_pose(0).shape, (0, 4, 4))
        with self.assertRaisesRegex(ValueError, r"\(1, 4, 4\); it must be \(0, 4, 4\)"):
            self.solver.step_pose(np.eye(4)[None])


class FlatArrays(InFolder):
    def test_a_model_shows_its_arrays_and_is_made_of_them(self):
        model = fascicle.Model(fascicle.Scene.parse(SMALL_BAR), cache="")
        arrays = model.arrays
        self.assertEqual((arrays["mass"].dtype, arrays["mass"].shape), (np.float64, (45,)))
        self.assertTrue(np.shares_memory(arrays["mass"], model.arrays["mass"]))
        self.assertFalse(arrays["mass"].flags.writeable)
        # A bar of 0.4 x 0.1 x 0.1 m at 1000 kg/m3 weighs 4 kg; sums of 45 doubles have at least twelve correct digits.
        self.assertAlmostEqual(arrays["mass"].sum(), 4.0, delta=1e-9)
        self.assertEqual(arrays["layer.name"], ["flesh"])
        copy = fascicle.Model.of_arrays(arrays)
        self.assertEqual(copy.vertex_count, 45)
        for name, array in copy.arrays.items():
            np.testing.assert_array_equal(array, arrays[name], err_msg=name)
        with self.assertRaisesRegex(fascicle.Error, "mass"):
            fascicle.Model.of_arrays({**arrays, "mass": arrays["mass"][1:]})
        with self.assertRaisesRegex(TypeError, "mass"):
            fascicle.Model.of_arrays({**arrays, "mass": arrays["mass"].astype(np.int16)})

    def test_arrays_of_the_other_byte_order_are_converted(self):
        arrays = fascicle.Model(fascicle.Scene.parse(SMALL_BAR), cache="").arrays
        others = {name: arrays[name].astype(arrays[name].dtype.newbyteorder()) for name in ("mass", "rest")}
        swapped = {**arrays, **others}
        self.assertFalse(swapped["rest"].dtype.isnative)
        for name, array in fascicle.Model.of_arrays(swapped).arrays.items():
            np.testing.assert_array_equal(array, arrays[name], err_msg=name)

    def test_the_arrays_outlive_the_name_of_their_model(self):
        mass = fascicle.Model(fascicle.Scene.parse(SMALL_BAR), cache="").arrays["mass"]
        self.assertTrue(np.all(mass > 0))

    def test_a_drive_moves_it(self):
        built = fascicle.Model(fascicle.Scene.parse(SMALL_BAR), cache="")
        solver = fascicle.Solver(fascicle.Model.of_arrays(built.arrays), fascicle.Device("cpu"))
        unit, origin = solver.unit, solver.origin
        before = solver.world_positions()[:, 1].min()
        for _ in range(6):
            solver.step_drive(h=1 / 60, origin=origin, gravity=[0, -9.81 / unit, 0], decay=np.ones(1, np.float32))
        self.assertLess(solver.world_positions()[:, 1].min(), before)
        with self.assertRaises(fascicle.BadArgument):
            solver.step_drive(h=0.0)
        with self.assertRaisesRegex(ValueError, r"bones has the shape \(3,\); it must be \(n, 16\)"):
            solver.step_drive(h=0.1, bones=np.zeros(3, np.float32))
        with self.assertRaisesRegex(fascicle.BadArgument, "array"):
            solver.start_clip()


class Poses(InFolder):
    def test_numpy_steps_as_the_wrapper_does(self):
        frames = 4
        scene = fascicle.Scene("arm", end=0.05)
        model = fascicle.Model(scene)
        solver = fascicle.Solver(model, fascicle.Device("cpu"))
        rest = solver.clip_pose(0)
        self.assertEqual((rest.shape, rest.dtype), ((len(scene.joint_names), 4, 4), np.float64))
        self.assertEqual(scene.joint_parents[0], -1)
        solver.start_pose(rest)
        hashes = []
        for frame in range(1, frames + 1):
            pose = rest.copy()
            pose[:, 1, 3] += 0.002 * frame
            solver.step_pose(pose)
            hashes.append(solver.position_hash)
        ran = subprocess.run([os.environ["FASCICLE_STEP_POSES"], "arm", "0.05", str(frames), self.path("surface")],
                             capture_output=True, text=True, timeout=300)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertEqual(hashes, ran.stdout.split())
        self.assertEqual(len(set(hashes)), frames)
        surface = np.fromfile(self.path("surface"), np.float32).reshape(-1, 3)
        np.testing.assert_array_equal(solver.world_surface(), surface)

        # One pose for each substep, ending at the frame's own.
        many = np.stack([pose] * model.substeps)
        solver.step_pose(many)
        for wrong in (rest[1:], rest.reshape(-1), rest[None, None], np.empty((0,) + rest.shape), None):
            with self.assertRaisesRegex(ValueError, "joints"):
                solver.step_pose(wrong)
        # Other number types are accepted too.
        solver.step_pose(pose.astype(np.float32).tolist())


class Threads(InFolder):
    def test_two_solvers_step_at_once(self):
        model = fascicle.Model(fascicle.Scene.parse(SMALL_BAR), cache="")
        hashes = []

        def run():
            solver = fascicle.Solver(model, fascicle.Device("cpu"))
            solver.start_clip()
            for _ in range(6):
                solver.step_clip()
            hashes.append(solver.position_hash)
        threads = [threading.Thread(target=run) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(hashes), 3)
        self.assertEqual(len(set(hashes)), 1)


if __name__ == "__main__":
    unittest.main()
