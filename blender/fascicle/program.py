"""The program `fascicle`: where it is, and one bake of it as a process. Knows nothing of Blender."""

import collections
import glob
import hashlib
import json
import os
import shutil
import subprocess
import threading

from .problem import Problem

NAME = "fascicle"
# Of what a bake's folder holds, the file that says that it is one.
MANIFEST = "manifest.json"
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


def replace_folder(new, old):
    """`new` takes the place of `old`, which is a bake or is not there."""
    if os.path.lexists(old):
        aside = old + ".old"
        shutil.rmtree(aside, ignore_errors=True)
        os.rename(old, aside)
        os.rename(new, old)
        shutil.rmtree(aside, ignore_errors=True)
    else:
        os.rename(new, old)


def check_folder(folder):
    """Raises Problem where a bake must not be written: nothing but a bake is ever replaced."""
    if not os.path.lexists(folder):
        return
    if not os.path.isdir(folder) or (os.listdir(folder) and not os.path.exists(os.path.join(folder, MANIFEST))):
        raise Problem("%s is there and is no bake; choose another folder" % folder)


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
        self.folder = folder
        self.part = folder + ".part"
        self.done, self.total = 0, 0
        self.message = ""
        self.warnings = []
        self._inputs, self._own_inputs = [], []
        check_folder(folder)
        check_folder(self.part)
        shutil.rmtree(self.part, ignore_errors=True)
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
        path = "%s-%s%s" % (self.folder, hashlib.sha256(data).hexdigest()[:INPUT_DIGITS], extension)
        self._inputs.append(path)
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
        replace_folder(self.part, self.folder)
        self._forget_earlier_inputs()
        self._own_inputs = []
        return True

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

    def _forget_earlier_inputs(self):
        """Those of the bake that was replaced."""
        for extension in (".glb", ".toml"):
            for path in glob.glob("%s-%s%s" % (glob.escape(self.folder), "[0-9a-f]" * INPUT_DIGITS, extension)):
                if path not in self._inputs:
                    os.remove(path)

    def _throw_away(self):
        shutil.rmtree(self.part, ignore_errors=True)
        for path in self._own_inputs:
            if os.path.exists(path):
                os.remove(path)
        self._own_inputs = []
