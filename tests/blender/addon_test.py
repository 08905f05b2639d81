"""The add-on as users get it: the zip from the build, installed by Blender's own operator, on characters imported
there. Without Blender the tests are skipped, loudly; with FASCICLE_REQUIRE_BLENDER=1 they fail."""

import ast
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile

PROGRAM = os.environ["FASCICLE_PROGRAM"]
ADDON = os.environ["FASCICLE_ADDON"]
HERE = os.path.dirname(os.path.abspath(__file__))
REPOSITORY = os.path.dirname(os.path.dirname(HERE))
ASSETS = os.path.join(REPOSITORY, "..", "shared", "assets")
# World positions go through several products of single-precision matrices on the way to the file and back; a few
# hundred roundings of 6e-8 of the body's size stay below this.
FLOATS = 2e-5


def required(variable):
    return os.environ.get(variable) == "1"


class WithBlender(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if not shutil.which("blender"):
            if required("FASCICLE_REQUIRE_BLENDER"):
                raise AssertionError("FASCICLE_REQUIRE_BLENDER=1, and no blender on the PATH")
            raise unittest.SkipTest("SKIPPED, NOT TESTED: no blender on the PATH")
        folder = tempfile.TemporaryDirectory(prefix="fascicle-blender-")
        cls.addClassCleanup(folder.cleanup)
        cls.shared = folder.name
        cls.environment = dict(os.environ, FASCICLE_CACHE_DIR=os.path.join(cls.shared, "cache"),
                               PATH=os.path.dirname(PROGRAM) + os.pathsep + os.environ["PATH"])
        for name in ("RESOURCES", "SCRIPTS", "CONFIG"):
            cls.environment["BLENDER_USER_" + name] = os.path.join(cls.shared, "user", name.lower())
        cls.blender("--python-expr", "import bpy; bpy.ops.preferences.addon_install(filepath=%r)" % ADDON)
        # One of our characters: the arm, whose clip is a curl.
        subprocess.run([PROGRAM, "bake", "arm", "-o", os.path.join(cls.shared, "arm"), "--end", "1"], check=True,
                       capture_output=True, env=cls.environment)
        cls.arm = os.path.join(cls.shared, "arm", "character.glb")

    @classmethod
    def blender(cls, *arguments, before=("blender", "--background")):
        ran = subprocess.run([*before, "--factory-startup", "--python-exit-code", "1", *arguments], capture_output=True,
                             text=True, timeout=3000, env=cls.environment)
        if ran.returncode != 0:
            raise AssertionError(ran.stdout[-4000:] + ran.stderr[-4000:])
        return ran.stdout

    def check(self, name, character, before=("blender", "--background"), **said):
        """Runs a check of in_blender.py with a new folder; returns what it found."""
        folder = tempfile.TemporaryDirectory(prefix="fascicle-blender-")
        self.addCleanup(folder.cleanup)
        said.setdefault("folder", os.path.join(folder.name, "bakes"))
        result = os.path.join(folder.name, "result.json")
        self.blender("--python", os.path.join(HERE, "in_blender.py"), "--", name, result, character,
                     *("%s=%s" % pair for pair in said.items()), before=before)
        with open(result) as file:
            return json.load(file)

    def asset(self, name):
        path = os.path.join(ASSETS, name)
        if not os.path.exists(path):
            if required("FASCICLE_REQUIRE_ASSETS"):
                self.fail("FASCICLE_REQUIRE_ASSETS=1, and there is no " + path)
            self.skipTest("SKIPPED, NOT TESTED: there is no " + path)
        return path


class RoundTrip(WithBlender):
    """From Blender to the program and back: the flesh's vertices are exactly the bake's floats, placed where the mesh
    is."""

    def expect_shown(self, found, frames, objects=1):
        self.assertEqual(found["error"], 0.0)
        self.assertEqual(found["frames"], frames)
        self.assertEqual(found["objects"], objects)
        self.assertEqual(found["frame"], 3)
        self.assertTrue(found["materials_kept"] and found["hidden"] and found["shown"])
        self.assertEqual((found["left"], found["collections_left"]), ([], []))

    def expect_placed(self, found):
        """Flesh that only follows the skeleton matches skinning in Blender's world, in every frame."""
        self.assertGreater(found["moved"], 0.02, "the clip moves nothing, so the check says nothing")
        self.assertLess(found["median"], FLOATS)

    def test_a_character_of_our_own(self):
        found = self.check("round_trip", self.arm, only="hand", first=14, last=20)
        self.expect_shown(found, 7)
        self.expect_placed(found)
        self.assertEqual(found["modifiers"], ["MESH_CACHE", "SUBSURF"])

    def test_its_flesh_leaves_the_skeleton(self):
        # The control for the two checks above: free flesh differs from skinning.
        found = self.check("round_trip", self.arm, first=14, last=20)
        self.expect_shown(found, 7)
        self.assertGreater(found["largest"], 50 * FLOATS)

    def test_centimetres_and_an_armature_that_stands_turned(self):
        found = self.check("round_trip", self.arm, only="hand", first=14, last=20, unit=0.01, moved=1)
        self.expect_shown(found, 7)
        self.expect_placed(found)

    def test_frames_that_begin_below_zero_and_another_rate(self):
        found = self.check("round_trip", self.arm, only="hand", first=-3, last=20, fps=30)
        self.expect_shown(found, 24)
        self.expect_placed(found)

    def test_shape_keys(self):
        found = self.check("round_trip", self.arm, only="hand", first=14, last=20, kind="SHAPE_KEYS")
        # A key stores positions, and its difference is added to the basis: one rounding each.
        self.assertLess(found["error"], 1e-6)
        self.assertEqual(found["modifiers"], ["SUBSURF"])
        self.expect_placed(found)

    def test_characters_of_others(self):
        for name, objects in (("CesiumMan.glb", 1), ("RobotExpressive.glb", None)):
            with self.subTest(name):
                found = self.check("round_trip", self.asset(name))
                self.expect_shown(found, 7, objects or found["objects"])
                self.assertGreater(found["materials"], 0)
                self.assertGreater(found["moved"], 0.0)


class Actions(WithBlender):
    def test_a_list_is_baked_and_the_open_one_is_shown(self):
        found = self.check("list_of_actions", self.arm)
        self.assertEqual(sorted(found["bakes"].values()), [4, 7])  # frames 2 to 5, and 2 to 8
        self.assertEqual(found["open"], found["first"])
        self.assertEqual(found["shown"], [found["first"]])
        self.assertEqual((found["open_after_show"], found["shown_after_show"]), ("second", ["second"]))

    def test_no_action_of_a_list_leaves_something_in_the_pose(self):
        found = self.check("pose_between_actions", self.arm, bone="forearm")
        self.assertEqual(found["bakes"], 2)
        self.assertEqual(found["after"], found["before"])
        self.assertEqual(len(found["written"][0]), 1)
        self.assertEqual(*found["written"])


class Again(WithBlender):
    def test_a_second_bake_replaces_the_first_and_keeps_the_users_files(self):
        found = self.check("again", self.arm)
        self.assertIn("object-1.pc2", found["files"])
        self.assertEqual(found["files_after"], sorted(found["files"] + ["render.png"]))
        self.assertEqual((found["error"], found["frames"]), (0.0, 4))
        # The folder and its input, which has another name after another bake.
        self.assertEqual((len(found["beside"]), len(found["beside_after"])), (2, 3))
        self.assertIn(found["backup"], found["beside_after"])
        self.assertEqual((found["mine"], found["kept_backup"]), (["mine", "mine"], True))

    def test_a_second_bake_takes_the_character_as_it_is_now(self):
        found = self.check("moved_after_bake", self.arm, last=3)
        for change, (with_flesh, by_skinning) in found["pairs"].items():
            self.assertRegex(by_skinning, "^[0-9a-f]{64}$", change)
            self.assertEqual(with_flesh, by_skinning, change)
        # The control: what is written differs after each change but hiding.
        written = [found["as baked"], *(by_skinning for _, by_skinning in found["pairs"].values())]
        self.assertEqual(len(set(written)), 3, written)


class Scene(WithBlender):
    """What is taken from the scene, and what is put into it."""

    def test_what_the_user_hides_is_left_alone(self):
        found = self.check("hidden_meshes", self.arm, last=2)
        self.assertEqual(found["baked"], [["body", "hat"], ["body"]])
        self.assertFalse(found["hat"], "a mesh that the second bake left out stayed hidden")
        self.assertEqual(found["with_flesh"], found["before"])
        self.assertEqual(found["after"], found["before"])
        self.assertTrue(found["flesh_shown"] and found["shown"])
        self.assertIn("moves no mesh that is shown; in the view and for renders, show body or by_eye",
                      found["all hidden"])

    def test_no_armature_moves_the_flesh_again(self):
        found = self.check("two_armature_modifiers", self.arm, first=14, last=16)
        self.assertEqual(found, {"error": 0.0, "frames": 3, "modifiers": ["MESH_CACHE", "SUBSURF"],
                                 "of_the_mesh": ["ARMATURE", "ARMATURE", "SUBSURF"]})

    def test_flesh_finds_its_armature_and_mesh_under_new_names(self):
        found = self.check("renamed", self.arm, last=2)
        self.assertEqual(found, {"skinned": True, "hidden": True, "panel": True, "shown": True, "left": []})


class Meanwhile(WithBlender):
    """What happens to the scene while the program works."""

    def test_a_bake_outlives_the_objects_that_it_began_with(self):
        found = self.check("other_memory", self.arm, last=2)
        self.assertEqual(found["loaded"][0][1:], ["second"])
        self.assertEqual(found["loaded"][1], 1)
        # The second is as soft as the first, as the setting was when they began.
        self.assertEqual(*found["layers"])
        self.assertEqual(found["removed"], found["mesh"] + " is no longer there; it was removed or renamed")
        self.assertEqual(found["running"], 0)


class Cancel(WithBlender):
    def test_nothing_of_it_is_left_and_the_bake_before_it_is_whole(self):
        found = self.check("cancel", self.arm)
        self.assertGreater(found["seen"], 0)
        self.assertTrue(found["ended"] and found["kept"] and found["objects_kept"] and found["can_bake_again"])
        self.assertEqual((found["left"], found["running"]), (found["kept_files"], 0))


class Window(WithBlender):
    """In a window on an Xvfb display, where the operator is modal."""

    def check_in_window(self, name, **said):
        if not shutil.which("xvfb-run"):
            if required("FASCICLE_REQUIRE_BLENDER"):
                self.fail("FASCICLE_REQUIRE_BLENDER=1, and no xvfb-run on the PATH")
            self.skipTest("SKIPPED, NOT TESTED: no xvfb-run on the PATH")
        self.environment["LIBGL_ALWAYS_SOFTWARE"] = "1"
        return self.check(name, self.arm, before=("xvfb-run", "-a", "-s", "-screen 0 800x600x24", "blender"), **said)

    def test_an_undo_during_a_bake_does_not_end_it(self):
        found = self.check_in_window("undo_in_window", first=14, last=160)
        self.assertEqual(found, {"while_at_work": True, "undone": True, "flesh": 1})

    def test_blender_goes_on_while_the_program_works_and_cancel_ends_it(self):
        found = self.check_in_window("in_window", first=14, last=60)
        self.assertEqual((found["pressed"], found["while_at_work"]), (["RUNNING_MODAL"], True))
        self.assertGreater(found["ticks"], 1)
        self.assertEqual(found["shares"], sorted(found["shares"]))
        self.assertEqual((found["flesh"], found["flesh_after"], found["cancelled"]), (1, 1, True))
        self.assertEqual(found["files_after"], found["files"])


class Refused(WithBlender):
    def test_each_trouble_is_said_plainly(self):
        found = self.check("refused", self.arm)
        for what, words in (("wrong path", "no program at /nowhere/fascicle; set its path in Edit > Preferences"),
                            ("not on the path", "not on the PATH; install it, or set its path"),
                            ("a bone that is not there", "no such bone"),
                            ("not saved", "Save the .blend file first"),
                            ("an empty list", "list of actions is empty"),
                            ("two actions of one folder", "The actions Walk 1 and Walk_1 would be baked into the same"),
                           ("the folder of another action's bake", "The actions Walk 1 and Walk_1 would be"),
                           ("a modifier before the armature's", "Mirror stands before the armature's"),
                            ("rest position", "set it to Pose Position"),
                            ("a folder that is no bake", "is no bake; choose another folder")):
            self.assertIn(words, found[what], what)
            self.assertTrue(found[what].startswith("Error: "), found[what])
        self.assertEqual(found["theirs"], ["mine.txt"])
        self.assertEqual(len(found["left"]), 1, found["left"])
        self.assertEqual(found["flesh"], [])

    def test_trouble_in_the_second_bake_of_a_list_ends_the_work(self):
        found = self.check("trouble_later", self.arm, bone="upper_arm", last=2)
        self.assertIn("Error: Bone upper_arm is scaled to 0 in frame 1, by itself or by a bone above it", found["zero"])
        self.assertNotIn("Traceback", found["zero"])
        self.assertIn("Traceback", found["of the add-on"])
        self.assertEqual((found["running"], found["after"]), (0, "finished"))


class Settings(WithBlender):
    def test_groups_of_like_names_are_different_layers(self):
        found = self.check("groups_of_like_names", self.arm)
        self.assertEqual(found["marked"], [[group] for group in found["groups"]])
        self.assertEqual(len(set(found["names"])), len(set(found["groups"])))
        self.assertEqual(found["names"][0], "_GROUP_FAT_L")
        self.assertTrue(found["legal"], found["names"])

    def test_groups_and_layers_reach_the_program(self):
        found = self.check("painted", self.arm, last=2)
        count = found["count"]
        self.assertEqual(found["layer"], "belly fat")
        self.assertEqual((found["cartoon"], found["heavier"]), ([2.0, 2.0, 1000.0], [1.0, 1.0, 1600.0]))
        self.assertIn("--set=layers.fat.density=1600.0", found["options"])
        self.assertNotIn("--softness", " ".join(found["options"]))
        painted = found["attributes"]
        self.assertEqual(painted["_LAYER"], [1.0] * (count // 4) + [0.0] * (count - count // 4))
        # Flesh outside the group is as stiff as its layer.
        self.assertEqual(painted["_STIFFNESS"], [0.5] * (count // 2) + [1.0] * (count - count // 2))
        self.assertEqual(painted["_GROUP_BELLY_FAT"][:2], [0.25, 0.0])
        self.assertEqual(sum(painted["_GROUP_BELLY_FAT"]), 0.25 + count // 2 - count // 4)
        layers = {layer["name"]: layer for layer in found["manifest"]["scene"]["layers"]}
        # Bone is last because the last matching layer applies.
        self.assertEqual(list(layers), ["fat", "muscle", "painted-0", "bone"])
        self.assertEqual(layers["painted-0"]["youngs_modulus"], 5500.0)
        self.assertEqual(layers["fat"]["density"], 1600.0)
        self.assertIn("_GROUP_BELLY_FAT", json.dumps(layers["painted-0"]["where"]))
        vertices = {layer["name"]: layer["vertices"] for layer in found["manifest"]["model"]["layers"]}
        self.assertGreater(vertices["painted-0"], 0)
        self.assertGreater(vertices["bone"], 0)


class Archive(unittest.TestCase):
    """The zip itself; needs no Blender."""

    def test_the_same_files_give_the_same_bytes(self):
        with open(os.path.join(REPOSITORY, "blender", "CMakeLists.txt")) as file:
            self.assertIn("pack.py", file.read())
        with zipfile.ZipFile(ADDON) as archive:
            names = [name.split("/", 1)[1] for name in archive.namelist() if not name.endswith("LICENSE")]
            self.assertEqual({name.split("/")[0] for name in archive.namelist()}, {"fascicle"})
            self.assertIn("fascicle/LICENSE", archive.namelist())
        source = os.path.join(REPOSITORY, "blender", "fascicle")
        self.assertEqual(sorted(names), sorted(name for name in os.listdir(source) if name.endswith(".py")))
        version = subprocess.run([PROGRAM, "--version"], capture_output=True, text=True, check=True).stdout.split()[1]
        with tempfile.TemporaryDirectory() as folder:
            # In another place, at another time, with another umask and file order.
            shutil.copytree(source, os.path.join(folder, "copy"), copy_function=shutil.copyfile)
            again = os.path.join(folder, "again.zip")
            subprocess.run([sys.executable, "-B", os.path.join(REPOSITORY, "blender", "pack.py"), again, version,
                            os.path.join(REPOSITORY, "LICENSE"), os.path.join(folder, "copy"), *reversed(names)],
                           check=True, preexec_fn=lambda: os.umask(0o077) and None)
            digests = []
            for path in (ADDON, again):
                with open(path, "rb") as file:
                    digests.append(hashlib.sha256(file.read()).hexdigest())
            self.assertEqual(*digests)

    # Python API removed in Blender 4.0 to 4.5 that an add-on like this might use.
    REMOVED = {"calc_normals", "calc_normals_split", "use_auto_smooth", "auto_smooth_angle", "create_normals_split",
               "free_normals_split", "face_maps", "vertex_colors", "bone_groups", "bone_group", "layers_protected",
               "annotation_active", "id_root", "load_on_startup", "context_override", "sculpt_vertex_colors"}

    def test_it_uses_nothing_that_blender_4_removed(self):
        with zipfile.ZipFile(ADDON) as archive:
            for name in archive.namelist():
                if not name.endswith(".py"):
                    continue
                used = {node.attr for node in ast.walk(ast.parse(archive.read(name)))
                        if isinstance(node, ast.Attribute)}
                self.assertEqual(used & self.REMOVED, set(), name)


if __name__ == "__main__":
    unittest.main()
