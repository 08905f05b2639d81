"""The bakes that the rows of reliability.py disturb, and the files of an undisturbed one."""

import hashlib
import json
import os
import random
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time

PROGRAM = os.path.abspath(os.environ.get("FASCICLE_PROGRAM", "fascicle"))
DEVICE = os.environ.get("FASCICLE_DEVICE", "cpu")  # of the disturbed bakes
# Files that say when and how a bake ran. All others have the same bytes whatever happened during the bake.
OF_ITS_RUN = ("manifest.json", "checkpoint")
UNFINISHED = (".part", ".tmp")
# Grows frame by frame under its final name; the checkpoint says how many frames are valid.
GROWING = "frames.fascicle"
HEADER_BYTES = 104  # of GROWING; then one record per frame

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 3, 75


def gpu():
    """The name of the GPU that the disturbed bakes run on; None if they run on the CPU."""
    if DEVICE.startswith("cpu"):
        return None
    said = subprocess.run([PROGRAM, "devices"], capture_output=True, text=True).stdout
    found = re.search(r"^%s +(.*)$" % re.escape(DEVICE), said, re.MULTILINE)
    if not found or not re.fullmatch(r"vulkan:\d+", DEVICE):
        sys.exit("FASCICLE_DEVICE is %s; it must be cpu, or one of those that `fascicle devices` lists" % DEVICE)
    return found.group(1)


class Broken(Exception):
    """A check failed."""


def hold(what, text):
    if not what:
        raise Broken(text)


def must_be_found(check, text):
    """A control: the check must fail."""
    try:
        check()
    except Broken:
        return
    raise Broken("the checks did not detect the control: " + text)


def digest(path, size=None):
    """(size, SHA-256) of a file or of its first `size` bytes. Reads in pieces: Linux starts a child's peak memory at
    that of this process."""
    found, done = hashlib.sha256(), 0
    with open(path, "rb") as file:
        while piece := file.read(1 << 20 if size is None else min(1 << 20, size - done)):
            found.update(piece)
            done += len(piece)
    return done, found.hexdigest()


def files(folder):
    """{relative path: digest} of all published files except those in OF_ITS_RUN."""
    found = {}
    for parent, folders, names in os.walk(folder):
        folders[:] = [name for name in folders if not name.endswith(UNFINISHED)]
        for name in names:
            path = os.path.join(parent, name)
            if name in OF_ITS_RUN or name.endswith(UNFINISHED):
                continue
            found[os.path.relpath(path, folder)] = digest(path)
    return found


def manifest(folder):
    """The parsed manifest; None without one. Raises Broken if it is truncated."""
    try:
        with open(os.path.join(folder, "manifest.json")) as file:
            return json.load(file)
    except FileNotFoundError:
        return None
    except ValueError as error:
        raise Broken("%s: truncated manifest: %s" % (folder, error)) from error


def frame_of_checkpoint(folder):
    """The frame after which a resumed bake continues; None without a checkpoint: it starts over."""
    try:
        with open(os.path.join(folder, "checkpoint"), "rb") as file:
            content = file.read()
        of_identity = struct.unpack_from("<8sII", content)[2]
        return struct.unpack_from("<Q", content, 16 + of_identity)[0]
    except FileNotFoundError:
        return None
    except struct.error as error:
        raise Broken("%s: truncated checkpoint: %s" % (folder, error)) from error


def hold_verified(folder):
    """`fascicle verify` finds every frame that should be there."""
    if manifest(folder) is not None:
        done = subprocess.run([PROGRAM, "verify", folder], capture_output=True, text=True)
        hold(done.returncode == DONE, "%s: verify exited with %d: %s" % (folder, done.returncode, done.stderr))


def everything_in(folder):
    return [os.path.join(parent, name) for parent, _, names in os.walk(folder) for name in names]


class Kept:
    """A snapshot of a folder, for later comparison. Keeps the frames open so that no new file gets their inode."""

    def __init__(self, folder):
        self.folder = folder
        self.checkpoint = frame_of_checkpoint(folder)
        said = manifest(folder)
        self.runs = None if said is None else said["timings"]["runs"]
        self.frames_asked = said["frames"] if said is not None and said["status"] == "complete" else None
        self.marks = self.marks_now()
        self.names = set(files(folder))
        path = os.path.join(folder, GROWING)
        self.frames = open(path, "rb") if os.path.exists(path) else None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.frames:
            self.frames.close()

    def marks_now(self):
        """Of each file what changes if it is written again, or renamed."""
        status = {path: os.lstat(path) for path in everything_in(self.folder)}
        return {path: (now.st_ino, now.st_ctime_ns) for path, now in status.items()}

    def hold_still_there(self):
        """Nothing was lost since the snapshot. Without a checkpoint anything goes: a resumed bake starts over. A
        resumed stream goes back to its unfinished name, and files of frames after the checkpoint are removed and
        written again."""
        if self.checkpoint is None:
            return
        now = frame_of_checkpoint(self.folder)
        hold(now is not None and now >= self.checkpoint,
             "%s: the checkpoint was at frame %d and is now at %s" % (self.folder, self.checkpoint, now))
        for name in self.names:
            path = os.path.join(self.folder, name)
            number = re.search(r"/frame_(\d+)\.\w+$", name)
            if number and int(number.group(1)) > self.checkpoint:
                continue
            hold(os.path.exists(path) or os.path.exists(path + ".part"), path + ": was lost")

    def hold_untouched(self):
        changed = sorted(path for path, mark in self.marks_now().items() if self.marks.get(path) != mark)
        hold(not changed, "complete, but %d files were written again, such as %s" % (len(changed), changed[:1]))

    def hold_gone_on(self):
        """A resumed bake continued what was there: the same frames file, and one more run."""
        said = manifest(self.folder)["timings"]["runs"]
        hold(self.runs is not None and said == self.runs + 1,
             "%s: run %s was resumed, but the manifest counts %d runs" % (self.folder, self.runs, said))
        now = os.stat(os.path.join(self.folder, GROWING))
        hold(self.frames and os.path.samestat(os.fstat(self.frames.fileno()), now),
             "%s/%s: is a new file: the bake started over" % (self.folder, GROWING))


class Bake:
    """One bake that runs many times, each time in a new folder."""

    def __init__(self, name, arguments, keeps_cache=True):
        self.name, self.arguments, self.keeps_cache = name, arguments, keeps_cache

    def prepare(self, folder):
        """Bakes it undisturbed; records its files and how long it takes."""
        self.root = folder
        self.cache = os.path.join(folder, "cache-" + self.name)
        whole = os.path.join(folder, "whole-" + self.name)
        for _ in range(2):  # the second run finds the body in the cache, if the bake keeps one
            shutil.rmtree(whole, ignore_errors=True)
            self.forget_body()
            begin = time.monotonic()
            done = self.run(whole)
            hold(done.returncode == DONE, "%s: %s" % (self.name, done.stderr))
            self.seconds = time.monotonic() - begin
        self.whole = files(whole)
        self.folder_of_whole = whole
        self.hashes = manifest(whole)["position_hashes"]
        hold(self.whole and self.hashes, self.name + ": nothing was baked")

    def command(self, folder, *more):
        device = () if "--device" in more else ("--device", DEVICE)
        return [PROGRAM, "bake", *self.arguments, *device, "-o", folder, *more]

    def environment(self, **more):
        # TMPDIR is in root, so that what a killed build leaves there is removed with the rest.
        return {**os.environ, "FASCICLE_CACHE_DIR": self.cache, "TMPDIR": self.root, **more}

    def run(self, folder, *more, **environment):
        return subprocess.run(self.command(folder, *more), capture_output=True, text=True,
                              env=self.environment(**environment))

    def forget_body(self):
        if not self.keeps_cache:
            shutil.rmtree(self.cache, ignore_errors=True)

    def start(self, folder, *more, **environment):
        """Runs it in a new process group, so that signals to the group also reach its children."""
        self.forget_body()
        return subprocess.Popen(self.command(folder, *more), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                text=True, env=self.environment(**environment), start_new_session=True)

    def start_listening(self, folder, *more):
        """The same, but returns only once SIGTERM has a handler. Before that, a signal would simply kill the
        process."""
        process = self.start(folder, *more)
        handler = 1 << (signal.SIGTERM - 1)
        while process.poll() is None:
            with open("/proc/%d/status" % process.pid) as file:
                caught = next((line.split()[1] for line in file if line.startswith("SigCgt:")), "0")
            if int(caught, 16) & handler:
                break
            time.sleep(0.0005)
        return process

    def empty_folder(self):
        return tempfile.mkdtemp(prefix=self.name + "-", dir=self.root)

    def moment(self):
        """A random delay in seconds, from the start of the process to about its end."""
        return random.uniform(0.0, self.seconds)

    def hold_published(self, folder):
        """Every file with its final name has the bytes of an undisturbed bake."""
        manifest(folder)
        for name, content in files(folder).items():
            hold(name in self.whole, "%s/%s: is not a file of an undisturbed bake" % (folder, name))
            whole = self.whole[name]
            if name == GROWING:
                whole = digest(os.path.join(self.folder_of_whole, name), content[0])
            hold(content == whole, "%s/%s: bytes differ" % (folder, name))

    def record_bytes(self):
        return (self.whole[GROWING][0] - HEADER_BYTES) // len(self.hashes)

    def frames_in(self, folder):
        """The number of complete frames in the file."""
        try:
            size = os.path.getsize(os.path.join(folder, GROWING))
        except FileNotFoundError:
            return 0
        return max(0, size - HEADER_BYTES) // self.record_bytes()

    def hold_counted(self, folder):
        """Published files have the right bytes, and every frame that the checkpoint or the manifest counts exists."""
        self.hold_published(folder)
        checkpoint = frame_of_checkpoint(folder)
        hold(checkpoint is None or self.frames_in(folder) > checkpoint,
             "%s: %d frames, but the checkpoint is at frame %s" % (folder, self.frames_in(folder), checkpoint))
        hold_verified(folder)

    def hold_whole(self, folder):
        self.hold_published(folder)
        missing = set(self.whole) - set(files(folder))
        hold(not missing, "%s: missing: %s" % (folder, ", ".join(sorted(missing))))
        size = os.path.getsize(os.path.join(folder, GROWING))
        hold(size == self.whole[GROWING][0], folder + ": frames are missing")
        hold(manifest(folder)["position_hashes"] == self.hashes, folder + ": position hashes differ")

    def resume(self, folder, *more):
        """Resumes the bake to its end. Returns whether it continued from a checkpoint."""
        with Kept(folder) as kept:
            done = self.run(folder, "--resume", *more)
            hold(done.returncode == DONE, "%s: --resume exited with %d: %s" % (folder, done.returncode, done.stderr))
            self.hold_whole(folder)
            if kept.names == set(self.whole) and kept.frames_asked == len(self.hashes) - 1:
                kept.hold_untouched()
            elif kept.checkpoint is not None:
                kept.hold_gone_on()
            return kept.checkpoint is not None


def end_by(process, number):
    """Signals the process and its children, which may have exited already."""
    try:
        os.killpg(process.pid, number)
    except ProcessLookupError:
        pass
    process.communicate()


CHARACTER = ["crouch", "--set", "character.resolution=0.12", "--set", "motion.hold=0.0"]


def a_kept_body():
    """A two-frame bake of a character with a cached body, for tests that run it thousands of times."""
    return Bake("short-bear", [*CHARACTER, "--end", "0.034", "--format", "pc2"])


def small_bakes():
    """A bar with one file per frame, a character in all formats with a cached body, and a character whose body is built
    and settled in every run."""
    character = [*CHARACTER, "--end", "0.3"]
    return [Bake("bar", ["bar-hang-none", "--end", "3", "--format", "pc2,obj"]),
            Bake("bear", [*character, "--format", "abc,glb,mdd,obj,pc2,usda,vtp,vtu"]),
            Bake("built-bear", [*character, "--set", "motion.settle=0.2", "--format", "abc"], keeps_cache=False)]


def killed_at_work(bake, folder, *more):
    """Starts a bake and kills it at a random moment; returns whether it was still running. If a bake from the start had
    already finished, later kills come earlier: how long a bake takes depends on the load of the machine."""
    process = bake.start(folder, *more)
    time.sleep(bake.moment())
    was_at_work = process.poll() is None
    end_by(process, signal.SIGKILL)
    if not was_at_work and not more:
        bake.seconds *= 0.8
    return was_at_work


def control_of_files(bakes):
    """A finished bake with one truncated file, and one with a wrong byte."""
    bake = bakes[0]
    folder = bake.empty_folder()
    shutil.copytree(bake.folder_of_whole, folder, dirs_exist_ok=True)
    bake.hold_whole(folder)
    path = os.path.join(folder, max(bake.whole, key=bake.whole.get))
    with open(path, "r+b") as file:
        file.truncate(os.path.getsize(path) // 2)
    must_be_found(lambda: bake.hold_whole(folder), "half a file")
    if os.path.basename(path) == GROWING:
        must_be_found(lambda: hold_verified(folder), "missing frames")
    with open(path, "r+b") as file:
        file.write(b"?")
    must_be_found(lambda: bake.hold_published(folder), "a wrong byte")
    shutil.rmtree(folder)


def control_of_going_on(bakes):
    """A bake that lost its checkpoint is not replaced, and one that starts over is seen; so is one that lost a file."""
    bake = bakes[0]
    folder = bake.empty_folder()
    shutil.copytree(bake.folder_of_whole, folder, dirs_exist_ok=True)
    with Kept(folder) as kept:
        os.remove(os.path.join(folder, "checkpoint"))
        must_be_found(kept.hold_still_there, "a lost checkpoint")
        done = bake.run(folder, "--resume")
        hold(done.returncode == 3 and "checkpoint" in done.stderr, done.stderr)
        done = bake.run(folder, "--overwrite")
        hold(done.returncode == DONE, done.stderr)
        bake.hold_whole(folder)
        must_be_found(kept.hold_gone_on, "a bake that starts over")
        must_be_found(kept.hold_untouched, "a complete bake that is written again")
    with Kept(folder) as kept:
        os.remove(os.path.join(folder, "surface.pc2"))
        must_be_found(kept.hold_still_there, "a lost file")
    shutil.rmtree(folder)
