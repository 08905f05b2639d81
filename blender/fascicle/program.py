"""The program `fascicle`: where it is, and one bake of it as a process. Knows nothing of Blender."""

import collections
import contextlib
import hashlib
import itertools
import json
import os
import re
import shutil
import subprocess
import threading

from . import point_cache
from .problem import Problem

NAME = "fascicle"
# Of what a bake's folder holds, the file that says that it is one.
MANIFEST = "manifest.json"
BAKE_KIND = "fascicle bake"
# As in all_file_names of host/bake/manifest.cpp. Folders of frames and textures are apart.
FILE_OF_BAKE = re.compile(r"manifest\.json|checkpoint|model\.fascicle|character\.glb|rest\.obj|rest\.mtl"
                          r"|import_blender\.py|frames\.fascicle|metrics\.csv|surface\.\w+")
# What else a format leaves: files next to its frames, and streams of an unfinished file.
BESIDE = {"obj/": "obj/surface.mtl", "vtp/": "vtp/series.pvd", "vtu/": "vtu/series.pvd",
          "surface.glb": "surface.glb.targets", "surface.usda": "surface.usda.samples"}
SECONDS_TO_STOP = 10
# What the program says before it ends badly is more than its last line.
LINES_KEPT = 20
# Of an input's hash, in its name.
INPUT_DIGITS = 16


def find_program(preferred):
    """The program's path: the one of the preferences, else the first on PATH. Raises Problem."""
    where = "set its path in Edit > Preferences > Add-ons > fascicle"
    if preferred:
        if os.path.isdir(preferred):
            preferred = os.path.join(preferred, NAME)
        found = shutil.which(preferred)
        if not found:
            raise Problem("There is no program at %s; %s" % (preferred, where))
        return found
    found = shutil.which(NAME)
    if not found:
        raise Problem("The program fascicle is not on the PATH; install it, or %s" % where)
    return found


def _manifest_in(folder):
    """Empty where there is none, or it is not fascicle's, or is damaged."""
    try:
        with open(os.path.join(folder, MANIFEST), encoding="utf-8") as file:
            manifest = json.load(file)
    except (OSError, ValueError, RecursionError):
        return {}
    return manifest if isinstance(manifest, dict) and manifest.get("kind") == BAKE_KIND else {}


def _free_name(path, what):
    """A name beside `path` that nothing has, such as PATH.old-1."""
    return next(name for name in ("%s.%s-%d" % (path, what, number) for number in itertools.count(1))
                if not os.path.lexists(name))


def _is_real_folder(path):
    return os.path.isdir(path) and not os.path.islink(path)


def _name_pattern(entry):
    """Matches the files of one entry of a manifest's list, as --overwrite does in host/bake/folder.cpp. None for an
    entry that no bake writes: a manifest may list anything."""
    if entry == "textures/":
        names = [r"textures/image_\d{3,}\.(png|jpg)"]
    elif re.fullmatch(r"\w+/", entry):
        names = [r"%sframe_\d{6,}\.%s" % (entry, entry[:-1])]
    elif FILE_OF_BAKE.fullmatch(entry):
        names = [re.escape(entry)]
    else:
        return None
    if entry in BESIDE:
        names.append(re.escape(BESIDE[entry]))
    return r"(%s)(\.part|\.tmp)?" % "|".join(names)


def _files_of_bake(folder):
    """The paths in `folder` of the files that its bake, its exports and this add-on wrote."""
    files = _manifest_in(folder).get("files")
    entries = {entry for entry in files if isinstance(entry, str)} if isinstance(files, list) else set()
    own = re.compile("|".join(filter(None, map(_name_pattern, entries))) or "(?!)")
    names = os.listdir(folder)
    for entry in entries:
        if entry.endswith("/") and _name_pattern(entry) and _is_real_folder(os.path.join(folder, entry[:-1])):
            names += [entry + name for name in os.listdir(os.path.join(folder, entry))]
    own_names = [name for name in names if own.fullmatch(name)]
    if point_cache.NAME in own_names:
        own_names += point_cache.parts_in(folder)
    paths = [os.path.join(folder, name) for name in own_names]
    return [path for path in paths if not _is_real_folder(path)]


def _remove_bake(folder):
    """Removes the bake's files, and folders of its frames that are then empty."""
    paths = _files_of_bake(folder)
    for path in paths:
        os.remove(path)
    for inner in {os.path.dirname(path) for path in paths} - {folder}:
        with contextlib.suppress(OSError):
            os.rmdir(inner)


def _move_over(source, target):
    """Moves what is in `source` into `target`; what has a name that is taken there stays."""
    for name in os.listdir(source):
        old, new = os.path.join(source, name), os.path.join(target, name)
        if _is_real_folder(old) and _is_real_folder(new):
            _move_over(old, new)
            with contextlib.suppress(OSError):
                os.rmdir(old)
        # The add-on cuts the cache into parts later, and must not overwrite a file of the user.
        elif not os.path.lexists(new) and not point_cache.is_part_name(name):
            os.rename(old, new)


def replace_folder(new, old):
    """`new` takes the place of `old`, which is a bake or is not there. Of `old` only the files of its bake are removed.
    The user's own move along. Returns the folder in which some of those had to stay, or None."""
    if not os.path.lexists(old):
        os.rename(new, old)
        return None
    # If this process dies before the new bake is in its place, the earlier one is whole under one of these two names.
    aside = _free_name(old, "old")
    os.rename(old, aside)
    try:
        os.rename(new, old)
    except BaseException:
        os.rename(aside, old)
        raise
    try:
        _remove_bake(aside)
        _move_over(aside, old)
        # Fails if something stayed.
        os.rmdir(aside)
    except OSError:
        return aside
    return None


def check_folder(folder):
    """Raises Problem where a bake must not be written: nothing but a bake is ever replaced."""
    if not os.path.lexists(folder):
        return
    if not os.path.isdir(folder) or (os.listdir(folder) and not _manifest_in(folder)):
        raise Problem("%s is there and is no bake; choose another folder" % folder)


def _inputs_of(folder):
    """The paths of the files that the bake in `folder` was made from, without links."""
    inputs = _manifest_in(folder).get("inputs")
    files = [entry.get("file") for entry in inputs if isinstance(entry, dict)] if isinstance(inputs, list) else []
    return {os.path.realpath(file) for file in files if isinstance(file, str)}


def _input_path(folder, data, extension):
    """Where the input with these bytes lies, for the bake in `folder`."""
    return "%s-%s%s" % (folder, hashlib.sha256(data).hexdigest()[:INPUT_DIGITS], extension)


def scene_with_layers(program, character, fps, layers):
    """The text of the program's own scene of a character, with `layers` (TOML) between its flesh and its bone: of
    several layers that claim a point the last has it, and bone must hold the flesh."""
    ran = subprocess.run([program, "scenes", character, "--fps", repr(fps)], stdin=subprocess.DEVNULL,
                         capture_output=True, text=True, encoding="utf-8", errors="replace", check=False)
    if ran.returncode != 0:
        raise Problem("fascicle ended with %d: %s" % (ran.returncode, ran.stderr.strip()))
    bone = "\n[layers.bone]\n"
    before, found, after = ran.stdout.partition(bone)
    if not found:
        raise Problem("fascicle's scene of the character has no bone; take the painted layers away")
    return before + "\n" + layers + found + after


class Bake:
    """A bake at work. It writes beside `folder`, which it replaces when it is whole and never touches before. What was
    baked stays beside it too, under a name by its content, as the program asks for it again when it draws the bake."""

    def __init__(self, program, character, folder, fps, options, layers=""):
        # A bake replaces the folder that a link leads to, not the link.
        self.folder = os.path.realpath(folder) if os.path.islink(folder) else folder
        self.done, self.total = 0, 0
        self.message = ""
        self.warnings = []
        self._own_inputs = []
        check_folder(self.folder)
        # Made here, so that what is thrown away is never the user's: their bakes may be named like a part.
        self.part = _free_name(self.folder, "part")
        os.mkdir(self.part)
        try:
            with open(character, "rb") as file:
                source = self._keep_input(file.read(), ".glb")
            if layers:
                source = self._keep_input(scene_with_layers(program, source, fps, layers).encode(), ".toml")
            self._start([program, "bake", source, "-o", self.part, "--fps=%r" % fps, "--format", "pc2", "--log-format",
                         "json", *options])
        except BaseException:
            self._throw_away()
            raise

    def _keep_input(self, data, extension):
        """The path where these bytes lie from now on."""
        path = _input_path(self.folder, data, extension)
        if not os.path.exists(path):
            self._own_inputs.append(path)
            with open(path + ".part", "wb") as file:
                file.write(data)
            os.replace(path + ".part", path)
        return path

    def _start(self, command):
        self._said = collections.deque()
        self._last = collections.deque(maxlen=LINES_KEPT)
        try:
            self._process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                             stderr=subprocess.PIPE, text=True, encoding="utf-8", errors="replace")
        except OSError as error:
            raise Problem("%s does not start: %s" % (command[0], error.strerror)) from error
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self._process.stderr:
            self._said.append(line)

    def _hear(self):
        while self._said:
            line = self._said.popleft()
            try:
                said = json.loads(line)
                level, message = said["level"], said["message"]
            except (ValueError, TypeError, KeyError):
                self._last.append(line.strip())
                continue
            if level == "progress" and "frames" in said:
                self.done, self.total = said["frame"], said["frames"]
            elif level == "warning":
                self.warnings.append(message)
            elif level == "error":
                self._last.append(message)
            self.message = message

    def poll(self):
        """True once the bake is whole and in its folder. Raises Problem where the program ended without one."""
        self._hear()
        status = self._process.poll()
        if status is None:
            return False
        self._end()
        if status != 0:
            self._throw_away()
            said = "; ".join(filter(None, self._last)) or "it said nothing"
            raise Problem("fascicle ended with %d: %s" % (status, said))
        self._take_place()
        return True

    def _take_place(self):
        earlier_inputs = _inputs_of(self.folder)
        # From here on the bake is whole, and is not thrown away.
        whole, self.part, self._own_inputs = self.part, None, []
        try:
            aside = replace_folder(whole, self.folder)
        except OSError as error:
            raise Problem("The bake is whole, but is still in %s: %s" % (whole, error)) from error
        if aside:
            self.warnings.append("Files that could not move into the new bake are in " + aside)
        # The new bake is in its place, so an input that cannot be read or removed is no trouble.
        with contextlib.suppress(OSError):
            self._forget_inputs(earlier_inputs)

    def wait(self):
        """Until poll() is true."""
        self._process.wait()
        self._reader.join()
        return self.poll()

    def cancel(self):
        """Ends the program and takes away what it wrote; an earlier bake stays as it was."""
        if self._process.poll() is None:
            self._process.terminate()
            try:
                self._process.wait(SECONDS_TO_STOP)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        self._end()
        self._throw_away()

    def _end(self):
        self._reader.join()
        self._process.stderr.close()
        self._hear()

    def _forget_inputs(self, paths):
        """Removes those that the add-on wrote for this folder, as their names say, and that no bake beside it was made
        from."""
        parent = os.path.dirname(os.path.realpath(self.folder))
        for folder in os.listdir(parent):
            paths = paths - _inputs_of(os.path.join(parent, folder))
        for path in filter(os.path.isfile, paths):
            with open(path, "rb") as file:
                data = file.read()
            if path == _input_path(os.path.realpath(self.folder), data, os.path.splitext(path)[1]):
                os.remove(path)

    def _throw_away(self):
        if self.part:
            shutil.rmtree(self.part, ignore_errors=True)
        for path in self._own_inputs:
            if os.path.exists(path):
                os.remove(path)
        self._own_inputs = []
