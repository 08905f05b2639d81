"""The add-on deletes nothing of the user's when it bakes again. Needs no Blender: program.py is loaded without the rest
of the add-on. A stand-in for the program writes small bakes; the class Exports asks the real one."""

import importlib
import json
import os
import runpy
import shutil
import struct
import subprocess
import sys
import tempfile
import types
import unittest
from unittest import mock

PROGRAM = os.environ["FASCICLE_PROGRAM"]
HERE = os.path.dirname(os.path.abspath(__file__))
ADDON = types.ModuleType("addon")  # the add-on's own __init__ needs Blender
ADDON.__path__ = [os.path.join(os.path.dirname(os.path.dirname(HERE)), "blender", "fascicle")]
sys.modules["addon"] = ADDON
program = importlib.import_module("addon.program")
point_cache = importlib.import_module("addon.point_cache")
Problem = importlib.import_module("addon.problem").Problem

# Each bake differs by the options that it gets; "fail" ends it badly.
STAND_IN = """#!%s
import json, os, struct, sys
source, folder, options = sys.argv[2], sys.argv[4], sys.argv[5:]
os.makedirs(folder + "/textures")
for name in ("metrics.csv", "textures/image_000.png"):
    with open(os.path.join(folder, name), "w") as file:
        file.write(" ".join(options))
with open(folder + "/surface.pc2", "wb") as file:
    file.write(struct.pack("<12siiffi", b"POINTCACHE2", 1, 5, 0.0, 1.0, 2) + bytes(2 * 5 * 12))
if "fail" in options:
    sys.exit(1)
with open(folder + "/manifest.json", "w") as file:
    json.dump({"kind": "fascicle bake", "files": ["manifest.json", "metrics.csv", "surface.pc2", "textures/"],
               "inputs": [{"file": source}], "options": options}, file)
""" % sys.executable

# What the user keeps in a bake's folder. Many names are nearly those of a bake.
OWN_FILES = ("render.png", "notes/shot 4.txt", "textures/mine.png", "textures/image_000.psd", "obj/frame_000001.obj",
             "surface.pc2.bak", "surface.abc", "manifest.json~", "old/manifest.json")


def everything(folder):
    """The bytes of each file and the target of each link, by its path in the folder."""
    found = {}
    for path, folders, files in os.walk(folder):
        for name in files + folders:
            full = os.path.join(path, name)
            if os.path.islink(full):
                found[os.path.relpath(full, folder)] = "to " + os.readlink(full)
            elif name in files:
                with open(full, "rb") as file:
                    found[os.path.relpath(full, folder)] = file.read()
    return found


def write(*path, data="mine"):
    path = os.path.join(*path)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w") as file:
        file.write(data)


def replace_as_before(new, old):
    """The fault that lost files."""
    aside = old + ".old"
    shutil.rmtree(aside, ignore_errors=True)
    if os.path.lexists(old):
        os.rename(old, aside)
    os.rename(new, old)
    shutil.rmtree(aside, ignore_errors=True)


class InFolder(unittest.TestCase):
    maxDiff = None  # controls look for a name in the message

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="fascicle-blender-")
        self.addCleanup(folder.cleanup)
        self.folder = os.path.join(folder.name, "bakes")
        self.bake_folder = os.path.join(self.folder, "man-walk")
        self.program = os.path.join(folder.name, "fascicle")
        self.character = os.path.join(folder.name, "character.glb")
        os.mkdir(self.folder)
        write(self.program, data=STAND_IN)
        os.chmod(self.program, 0o755)
        write(self.character, data="first character")

    def start(self, *options):
        return program.Bake(self.program, self.character, self.bake_folder, 24.0, list(options))

    def bake(self, *options):
        bake = self.start(*options)
        self.assertTrue(bake.wait())
        bake.cancel()  # as the add-on does at the end
        return bake


class Replaced(InFolder):
    def fresh(self, *options):
        """All files of a bake that replaced none."""
        with mock.patch.object(self, "bake_folder", os.path.join(self.folder, "apart", "man-walk")):
            os.mkdir(os.path.dirname(self.bake_folder))
            self.bake(*options)
            made = everything(self.bake_folder)
            shutil.rmtree(os.path.dirname(self.bake_folder))
        return made

    def without_manifest(self, files):
        # It names the input, whose path depends on the folder.
        return {name: data for name, data in files.items() if name != "manifest.json"}

    def expect_own_files_to_stay(self):
        expected = self.fresh("second")
        self.bake("first")
        for name in OWN_FILES:
            write(self.bake_folder, name, data="mine: " + name)
            expected[name] = b"mine: " + name.encode()
        os.symlink("nowhere", os.path.join(self.bake_folder, "link"))
        expected["link"] = "to nowhere"
        bake = self.bake("second")
        self.assertEqual(self.without_manifest(everything(self.bake_folder)), self.without_manifest(expected))
        self.assertEqual(bake.warnings, [])
        self.assertEqual(len(os.listdir(self.folder)), 2, "beside the bake is only its input")

    def test_the_users_files_stay_in_the_folder_and_the_earlier_bakes_go(self):
        self.expect_own_files_to_stay()

    def test_control_the_fault_that_lost_them_is_found(self):
        with mock.patch.object(program, "replace_folder", replace_as_before), \
                self.assertRaisesRegex(AssertionError, "render.png"):
            self.expect_own_files_to_stay()

    def test_control_files_of_the_earlier_bake_that_stay_are_found(self):
        with mock.patch.object(program, "_remove_bake"), self.assertRaisesRegex(AssertionError, "old-1"):
            self.expect_own_files_to_stay()

    def expect_neighbours_to_stay(self):
        self.bake("first")
        for name in ("man-walk.old/mine.txt", "man-walk.old-1/mine.txt", "man-walk.part-1/mine.txt",
                     "man-walk-0123456789abcdef.glb", "man-walk-0123456789abcdef.toml"):
            write(self.folder, name)
        # A whole bake, of an action named walk.part.
        shutil.copytree(self.bake_folder, self.bake_folder + ".part")
        before = {name: data for name, data in everything(self.folder).items() if not name.startswith("man-walk/")}
        self.bake("second")
        with self.assertRaises(Problem):
            self.bake("fail")
        self.start("third").cancel()
        after = everything(self.folder)
        self.assertEqual({name: after.get(name) for name in before}, before)
        self.assertEqual({name for name in after if not name.startswith("man-walk/")}, set(before))

    def test_a_backup_and_bakes_named_like_the_add_ons_folders_stay(self):
        self.expect_neighbours_to_stay()

    def test_control_a_deleted_backup_is_found(self):
        with mock.patch.object(program, "replace_folder", replace_as_before), \
                self.assertRaisesRegex(AssertionError, "man-walk.old/mine.txt"):
            self.expect_neighbours_to_stay()

    def test_control_a_deleted_bake_named_like_a_part_is_found(self):
        def name_as_before(path, what):
            shutil.rmtree(path + "." + what, ignore_errors=True)
            return path + "." + what

        with mock.patch.object(program, "_free_name", name_as_before), \
                self.assertRaisesRegex(AssertionError, "man-walk.part/metrics.csv"):
            self.expect_neighbours_to_stay()

    def test_a_file_whose_name_the_new_bake_takes_is_set_aside_and_said(self):
        write(self.bake_folder, "manifest.json", data=json.dumps({"kind": "fascicle bake", "files": ["manifest.json"]}))
        write(self.bake_folder, "metrics.csv")
        write(self.bake_folder, "textures", "image_000.png")
        write(self.bake_folder, "render.png")
        bake = self.bake("second")
        aside = self.bake_folder + ".old-1"
        self.assertEqual(everything(aside), {"metrics.csv": b"mine", "textures/image_000.png": b"mine"})
        self.assertEqual(bake.warnings, ["Files that could not move into the new bake are in " + aside])
        after = everything(self.bake_folder)
        self.assertEqual((after["metrics.csv"], after["render.png"]), (after["textures/image_000.png"], b"mine"))

    def test_a_manifest_cannot_have_other_files_deleted(self):
        write(self.folder, "outside.txt")
        own = ["render.png", "model.blend", "a/b.txt", "metrics.csv.bak", "checkpoint/a.txt"]
        for name in own:
            write(self.bake_folder, name)
        listed = ["manifest.json", "render.png", "model.blend", "a/", "a/b.txt", "../outside.txt", "../", "/", "", "./",
                  os.path.join(self.folder, "outside.txt"), "checkpoint", ".*", 5, None]
        write(self.bake_folder, "manifest.json", data=json.dumps({"kind": "fascicle bake", "files": listed}))
        self.bake("second")
        after = everything(self.folder)
        for name in ["outside.txt", *("man-walk/" + name for name in own)]:
            self.assertEqual(after.get(name), b"mine", name)

    def test_a_folder_with_a_manifest_of_another_program_is_refused(self):
        for text in ('{"name": "my web page"}', "[]", "{", "[" * 100000):
            write(self.bake_folder, "manifest.json", data=text)
            with self.subTest(text[:30]), self.assertRaisesRegex(Problem, "is no bake"):
                self.start("second")
        self.assertEqual(everything(self.folder), {"man-walk/manifest.json": text.encode()})

    def test_a_folder_that_someone_made_during_the_bake_is_kept(self):
        bake = self.start("first")
        write(self.bake_folder, "mine.txt")
        write(self.bake_folder, "metrics.csv")
        bake.wait()
        self.assertEqual(everything(self.bake_folder)["mine.txt"], b"mine")
        self.assertEqual(everything(self.bake_folder + ".old-1"), {"metrics.csv": b"mine"})
        self.assertEqual(len(bake.warnings), 1)

    def test_a_link_stays_and_its_folder_is_replaced(self):
        self.bake("first")
        real = os.path.join(self.folder, "large disk", "bake")
        os.mkdir(os.path.dirname(real))
        os.rename(self.bake_folder, real)
        os.symlink(real, self.bake_folder)
        write(self.bake_folder, "render.png")
        self.bake("second")
        self.assertEqual(os.readlink(self.bake_folder), real)
        self.assertEqual((everything(real)["metrics.csv"].split()[-1], everything(real)["render.png"]),
                         (b"second", b"mine"))

    def cut(self):
        point_cache.write_parts(os.path.join(self.bake_folder, "surface.pc2"),
                                [(os.path.join(self.bake_folder, point_cache.part_name(n)), n + 2) for n in (0, 1)])

    def test_the_parts_that_the_add_on_cut_go_with_the_bake(self):
        self.bake("first")
        self.cut()
        self.assertIn("object-1.pc2", os.listdir(self.bake_folder))
        bake = self.bake("second")
        self.assertEqual((set(everything(self.bake_folder)), bake.warnings), (set(self.fresh("second")), []))

    def test_files_that_are_only_named_like_parts_are_set_aside(self):
        # Where they are, the add-on would overwrite them when it cuts the new cache.
        longer = struct.pack("<12siiffi", b"POINTCACHE2", 1, 4, 0.0, 1.0, 2) + bytes(2 * 4 * 12)
        for data in (b"mine", longer):
            with self.subTest(len(data)):
                self.bake("first")
                self.cut()
                with open(os.path.join(self.bake_folder, "object-1.pc2"), "wb") as file:
                    file.write(data)
                aside = self.bake("second").warnings[0].rpartition(" ")[2]
                self.assertEqual(everything(aside)["object-1.pc2"], data)
                self.assertEqual(set(everything(self.bake_folder)), set(self.fresh("second")))


class Interrupted(InFolder):
    """Whatever fails and whenever the process dies, one bake is whole, and each of the user's files is there once."""

    def setUp(self):
        super().setUp()
        self.bake("first")
        self.first = everything(self.bake_folder)
        for name in OWN_FILES:
            write(self.bake_folder, name, data="mine: " + name)

    def expect_nothing_lost(self):
        """Returns the folders, of those beside the input, that hold a whole bake."""
        found = everything(self.folder)
        data = list(found.values())
        for name in OWN_FILES:
            self.assertEqual(data.count(b"mine: " + name.encode()), 1, name + " is not there once")
        whole = []
        for folder in os.listdir(self.folder):
            is_first = all(found.get(os.path.join(folder, name)) == data for name, data in self.first.items())
            second = [os.path.join(folder, name) for name in self.first]
            if is_first or all(found.get(name, b"first") and b"first" not in found.get(name, b"first")
                               for name in second):
                whole.append(folder)
        self.assertTrue(whole, "no bake is whole")
        return sorted(whole)

    def test_a_move_that_fails_leaves_the_earlier_bake_in_its_place(self):
        before = everything(self.bake_folder)
        rename = os.rename
        for failing in (self.bake_folder, self.bake_folder + ".part-1"):
            bake = self.start("second")

            def fail(source, target):
                if source == failing:
                    raise PermissionError(13, "Permission denied", source, None, target)
                rename(source, target)

            with self.subTest(failing), mock.patch.object(program.os, "rename", fail):
                with self.assertRaisesRegex(Problem, "The bake is whole, but is still in .*/man-walk.part-1: "):
                    bake.wait()
                bake.cancel()
                self.assertEqual(everything(self.bake_folder), before)
                self.assertEqual(self.expect_nothing_lost(), ["man-walk", "man-walk.part-1"])
            shutil.rmtree(self.bake_folder + ".part-1")

    def test_a_file_of_the_earlier_bake_that_cannot_be_removed_is_said(self):
        bake = self.start("second")
        with mock.patch.object(program.os, "remove", side_effect=PermissionError(13, "Permission denied")):
            bake.wait()
        self.assertIn("man-walk.old-1", bake.warnings[0])
        self.assertEqual(self.expect_nothing_lost(), ["man-walk", "man-walk.old-1"])

    DYING = """
import os, sys
sys.path.insert(0, %r)
import program_test
left = int(sys.argv[1])
def dies(call):
    def until(*arguments, **others):
        global left
        if left == 0:
            os._exit(9)
        left -= 1
        return call(*arguments, **others)
    return until
bake = program_test.program.Bake(*sys.argv[2:5], 24.0, ["second"])
if len(sys.argv) > 5:
    program_test.program.replace_folder = program_test.replace_as_before
for name in ("rename", "remove", "unlink", "rmdir"):
    setattr(os, name, dies(getattr(os, name)))
bake.wait()
""" % HERE

    def die_at_each_step(self, *fault):
        """Returns the whole bakes after each death."""
        whole = []
        while True:
            saved = self.folder + ".saved"
            shutil.copytree(self.folder, saved, symlinks=True)
            ran = subprocess.run([sys.executable, "-B", "-c", self.DYING, str(len(whole)), self.program, self.character,
                                  self.bake_folder, *fault], capture_output=True, text=True)
            self.assertIn(ran.returncode, (0, 9), ran.stderr)
            whole.append(self.expect_nothing_lost())
            shutil.rmtree(self.folder)
            os.rename(saved, self.folder)
            if ran.returncode == 0:
                return whole

    def test_a_death_at_any_step_loses_nothing(self):
        whole = self.die_at_each_step()
        self.assertGreater(len(whole), len(OWN_FILES), "each file is a step at least")
        self.assertEqual(whole[:3], [["man-walk", "man-walk.part-1"], ["man-walk.old-1", "man-walk.part-1"],
                                     ["man-walk", "man-walk.old-1"]])
        self.assertEqual({tuple(folders) for folders in whole[3:]}, {("man-walk",)})

    def test_control_the_fault_that_lost_files_is_found(self):
        with self.assertRaisesRegex(AssertionError, "is not there once"):
            self.die_at_each_step("as before")


class Inputs(InFolder):
    def inputs(self):
        found = {}
        for name, data in everything(self.folder).items():
            if name.endswith(".glb"):
                found[data.decode()] = os.path.join(self.folder, name)
        return found

    def bake_another_character(self):
        write(self.character, data="second character")
        self.bake("second")
        return set(self.inputs())

    def test_that_of_a_replaced_bake_goes(self):
        self.bake("first")
        self.assertEqual(set(self.inputs()), {"first character"})
        self.assertEqual(self.bake_another_character(), {"second character"})

    def test_that_of_a_copied_bake_stays(self):
        self.bake("first")
        shutil.copytree(self.bake_folder, os.path.join(self.folder, "backup"))
        self.assertEqual(self.bake_another_character(), {"first character", "second character"})

    def test_that_of_a_renamed_bake_stays(self):
        self.bake("first")
        os.rename(self.bake_folder, self.bake_folder + ".old")
        self.assertEqual(self.bake_another_character(), {"first character", "second character"})

    def test_one_that_was_changed_stays(self):
        self.bake("first")
        write(self.inputs()["first character"], data="a better character")
        self.assertEqual(self.bake_another_character(), {"a better character", "second character"})

    def test_a_character_that_the_add_on_did_not_write_stays(self):
        # A bake from the command line.
        self.bake("first")
        own = os.path.join(self.folder, "man-walk-mine.glb")
        write(own)
        manifest = os.path.join(self.bake_folder, "manifest.json")
        with open(manifest) as file:
            text = file.read()
        write(manifest, data=text.replace(self.inputs()["first character"], own))
        self.assertIn("mine", self.bake_another_character())


class Exports(InFolder):
    """The real program: its exports count as the bake's files, and no format's file is left."""

    def setUp(self):
        super().setUp()
        cache = mock.patch.dict(os.environ, FASCICLE_CACHE_DIR=os.path.join(self.folder, "..", "cache"))
        cache.start()
        self.addCleanup(cache.stop)
        self.program = PROGRAM

    def run_program(self, *arguments):
        return subprocess.run([PROGRAM, *arguments], check=True, capture_output=True, text=True).stdout

    def expect_as_fresh(self):
        arm = os.path.join(self.folder, "..", "arm")
        self.run_program("bake", "arm", "-o", arm, "--end=0.1")
        shutil.copy(os.path.join(arm, "character.glb"), self.character)
        self.bake("--end=0.1")
        fresh = set(everything(self.bake_folder))
        formats = self.run_program("export", "--help").partition("any of ")[2].partition("\n")[0]
        self.run_program("export", self.bake_folder, "--to", formats, "--overwrite")
        exported = everything(self.bake_folder)
        for name in ("surface.usda", "vtp/series.pvd", "obj/frame_000001.obj"):
            self.assertIn(name, exported)
        write(self.bake_folder, "render.png")
        write(self.bake_folder, "obj", "mine.obj")
        self.bake("--end=0.1", "--softness=1.1")
        self.assertEqual(set(everything(self.bake_folder)), fresh | {"render.png", "obj/mine.obj"})
        # A bake in every format, from the command line; vtu cannot be exported.
        self.run_program("bake", self.character, "-o", self.bake_folder, "--end=0.1", "--overwrite", "--format",
                         formats + ",vtu")
        self.assertIn("vtu/series.pvd", everything(self.bake_folder))
        self.bake("--end=0.1")
        self.assertEqual(set(everything(self.bake_folder)), fresh | {"render.png", "obj/mine.obj"})
        self.assertEqual([name for name in os.listdir(self.folder) if ".old" in name or ".part" in name], [])

    def test_they_go_with_the_bake_and_the_users_files_stay(self):
        self.expect_as_fresh()

    def test_control_a_file_that_is_left_is_found(self):
        with mock.patch.object(program, "BESIDE", {}), self.assertRaisesRegex(AssertionError, "vtp/series.pvd"):
            self.expect_as_fresh()


class ImportScript(unittest.TestCase):
    """import_blender.py of a bake. Blender 5 keeps an action's curves in layers alone; Blender 3 knows no layers."""

    def test_finds_curves_in_every_version(self):
        with tempfile.TemporaryDirectory() as folder:
            bake = os.path.join(folder, "bake")
            subprocess.run([PROGRAM, "bake", "bar-hang-none", "--end", "0.1", "--format", "pc2", "--device", "cpu",
                            "-o", bake],
                           check=True, capture_output=True)
            with mock.patch.dict(sys.modules, {"bpy": types.ModuleType("bpy")}):
                script = runpy.run_path(os.path.join(bake, "import_blender.py"))
        old = types.SimpleNamespace(fcurves=["a", "b"])
        bags = [types.SimpleNamespace(fcurves=["a"]), types.SimpleNamespace(fcurves=["b"])]
        new = types.SimpleNamespace(
            layers=[types.SimpleNamespace(strips=[types.SimpleNamespace(channelbags=bags)])])
        # From 4.4 to 4.5 actions have both, and the old list holds those of the first object alone.
        between = types.SimpleNamespace(fcurves=["a"], layers=new.layers)
        for action in (old, new, between):
            self.assertEqual(script["curves_of"](action), ["a", "b"])
        self.assertEqual(script["curves_of"](types.SimpleNamespace(layers=[])), [])


if __name__ == "__main__":
    unittest.main()
