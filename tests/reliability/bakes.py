"""Bakes that the rows of reliability.py disturb, and what an undisturbed one of them leaves."""

import hashlib
import json
import os
import random
import re
import shutil
import signal
import struct
import subprocess
import tempfile
import time

PROGRAM = os.path.abspath(os.environ.get("FASCICLE_PROGRAM", "fascicle"))
# Files that say when and how a bake ran; all others have the same bytes whatever happened on the way.
OF_ITS_RUN = ("manifest.json", "checkpoint")
UNFINISHED = (".part", ".tmp")
# Grows frame by frame under its own name; the checkpoint says how far it counts.
GROWING = "frames.fascicle"
HEADER_BYTES = 104  # of it; a record a frame follows

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 3, 75


class Broken(Exception):
    """Something that must hold does not."""


def hold(what, text):
    if not what:
        raise Broken(text)


def must_be_found(check, text):
    """A control: the check has to fail."""
    try:
        check()
    except Broken:
        return
    raise Broken("the control was not found out: " + text)


def digest(path, size=None):
    """(bytes, their SHA-256) of a file, or of its first `size` bytes. In pieces: a child's peak of memory, as the
    system counts it, begins with that of this process."""
    found, done = hashlib.sha256(), 0
    with open(path, "rb") as file:
        while piece := file.read(1 << 20 if size is None else min(1 << 20, size - done)):
            found.update(piece)
            done += len(piece)
    return done, found.hexdigest()


def files(folder):
    """{path below the folder: digest} of what is published, but for what says how the bake ran."""
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
    """What it says; None where there is none. Half of one is no JSON."""
    try:
        with open(os.path.join(folder, "manifest.json")) as file:
            return json.load(file)
    except FileNotFoundError:
        return None
    except ValueError as error:
        raise Broken("%s: a manifest that is torn: %s" % (folder, error)) from error


def frame_of_checkpoint(folder):
    """The frame after which a resumed bake goes on; None where there is none, and it begins anew."""
    try:
        with open(os.path.join(folder, "checkpoint"), "rb") as file:
            content = file.read()
        of_identity = struct.unpack_from("<8sII", content)[2]
        return struct.unpack_from("<Q", content, 16 + of_identity)[0]
    except FileNotFoundError:
        return None
    except struct.error as error:
        raise Broken("%s: a checkpoint that is torn: %s" % (folder, error)) from error


def hold_verified(folder):
    """No frame that counts is missing, as `fascicle verify` finds it."""
    if manifest(folder) is not None:
        done = subprocess.run([PROGRAM, "verify", folder], capture_output=True, text=True)
        hold(done.returncode == DONE, "%s: verify ended with %d: %s" % (folder, done.returncode, done.stderr))


class Kept:
    """What a folder has at one moment, for a later one. Its frames stay open: no new file gets their inode."""

    def __init__(self, folder):
        self.folder = folder
        self.checkpoint = frame_of_checkpoint(folder)
        said = manifest(folder)
        self.runs = None if said is None else said["timings"]["runs"]
        self.names = set(files(folder))
        path = os.path.join(folder, GROWING)
        self.frames = open(path, "rb") if os.path.exists(path) else None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.frames:
            self.frames.close()

    def hold_still_there(self):
        """Nothing was lost, but where no checkpoint was: then a resumed bake begins anew. A stream that is resumed has
        its unfinished name again, and files of frames that no checkpoint counts yet are taken back, to be written
        again."""
        if self.checkpoint is None:
            return
        now = frame_of_checkpoint(self.folder)
        hold(now is not None and now >= self.checkpoint,
             "%s: the checkpoint was of frame %d, and is of %s" % (self.folder, self.checkpoint, now))
        for name in self.names:
            path = os.path.join(self.folder, name)
            number = re.search(r"/frame_(\d+)\.\w+$", name)
            if number and int(number.group(1)) > self.checkpoint:
                continue
            hold(os.path.exists(path) or os.path.exists(path + ".part"), path + ": was there, and is lost")

    def hold_gone_on(self):
        """A resumed bake has gone on with what was there: the same file of frames, and one run more."""
        said = manifest(self.folder)["timings"]["runs"]
        hold(self.runs is not None and said == self.runs + 1,
             "%s: run %s went on, and the manifest counts %d runs" % (self.folder, self.runs, said))
        now = os.stat(os.path.join(self.folder, GROWING))
        hold(self.frames and os.path.samestat(os.fstat(self.frames.fileno()), now),
             "%s/%s: is another file: the bake began anew" % (self.folder, GROWING))


class Bake:
    """One bake, again and again, in folders of its own."""

    def __init__(self, name, arguments, keeps_cache=True):
        self.name, self.arguments, self.keeps_cache = name, arguments, keeps_cache

    def prepare(self, folder):
        """Bakes it undisturbed: what it leaves, and how long it takes."""
        self.root = folder
        self.cache = os.path.join(folder, "cache-" + self.name)
        whole = os.path.join(folder, "whole-" + self.name)
        for _ in range(2):  # the second has its body kept, where one is kept
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
        device = () if "--device" in more else ("--device", "cpu")
        return [PROGRAM, "bake", *self.arguments, *device, "-o", folder, *more]

    def environment(self, **more):
        # What a killed build leaves in its temporary folder goes with the rest.
        return {**os.environ, "FASCICLE_CACHE_DIR": self.cache, "TMPDIR": self.root, **more}

    def run(self, folder, *more, **environment):
        return subprocess.run(self.command(folder, *more), capture_output=True, text=True,
                              env=self.environment(**environment))

    def forget_body(self):
        if not self.keeps_cache:
            shutil.rmtree(self.cache, ignore_errors=True)

    def start(self, folder, *more):
        """In a process group of its own, so that its children are reached with it."""
        self.forget_body()
        return subprocess.Popen(self.command(folder, *more), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                text=True, env=self.environment(), start_new_session=True)

    def start_listening(self, folder, *more):
        """The same, once it has a handler for SIGTERM: before, the system ends it as any program that starts."""
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
        """At random, from the program's first line to about its last one."""
        return random.uniform(0.0, self.seconds)

    def hold_published(self, folder):
        """What has its final name has the bytes that it would have had undisturbed."""
        manifest(folder)
        for name, content in files(folder).items():
            hold(name in self.whole, "%s/%s: belongs to no whole bake" % (folder, name))
            whole = self.whole[name]
            if name == GROWING:
                whole = digest(os.path.join(self.folder_of_whole, name), content[0])
            hold(content == whole, "%s/%s: has other bytes" % (folder, name))

    def record_bytes(self):
        return (self.whole[GROWING][0] - HEADER_BYTES) // len(self.hashes)

    def frames_in(self, folder):
        """Whole frames that are written."""
        try:
            size = os.path.getsize(os.path.join(folder, GROWING))
        except FileNotFoundError:
            return 0
        return max(0, size - HEADER_BYTES) // self.record_bytes()

    def hold_counted(self, folder):
        """What is published has its bytes, and no frame is missing that the checkpoint or the manifest counts."""
        self.hold_published(folder)
        checkpoint = frame_of_checkpoint(folder)
        hold(checkpoint is None or self.frames_in(folder) > checkpoint,
             "%s: %d frames, and the checkpoint is of frame %s" % (folder, self.frames_in(folder), checkpoint))
        hold_verified(folder)

    def hold_whole(self, folder):
        self.hold_published(folder)
        missing = set(self.whole) - set(files(folder))
        hold(not missing, "%s: lacks %s" % (folder, ", ".join(sorted(missing))))
        size = os.path.getsize(os.path.join(folder, GROWING))
        hold(size == self.whole[GROWING][0], folder + ": frames are missing")
        hold(manifest(folder)["position_hashes"] == self.hashes, folder + ": other position hashes")

    def resume(self, folder, *more):
        """To its end. Whether there was a checkpoint, and it went on from there."""
        with Kept(folder) as kept:
            done = self.run(folder, "--resume", *more)
            hold(done.returncode == DONE, "%s: --resume ended with %d: %s" % (folder, done.returncode, done.stderr))
            self.hold_whole(folder)
            if kept.checkpoint is not None:
                kept.hold_gone_on()
            return kept.checkpoint is not None


def end_by(process, number):
    """The signal to the process and its children; it may be over."""
    try:
        os.killpg(process.pid, number)
    except ProcessLookupError:
        pass
    process.communicate()


CHARACTER = ["crouch", "--set", "character.resolution=0.12", "--set", "motion.hold=0.0"]


def a_kept_body():
    """A bake of two frames of a character whose body is kept, for what is done thousands of times."""
    return Bake("short-bear", [*CHARACTER, "--end", "0.034", "--format", "pc2"])


def small_bakes():
    """A bar with a file a frame, a character whose body is kept, in all formats, and one whose body is built and comes
    to rest in every run."""
    character = [*CHARACTER, "--end", "0.3"]
    return [Bake("bar", ["bar-hang-none", "--end", "3", "--format", "pc2,obj"]),
            Bake("bear", [*character, "--format", "abc,glb,mdd,obj,pc2,usda,vtp,vtu"]),
            Bake("built-bear", [*character, "--set", "motion.settle=0.2", "--format", "abc"], keeps_cache=False)]


def killed_at_work(bake, folder, *more):
    """Starts it and kills it at a random moment; whether it was still at work. Where one from the start was over
    before, the next moments are earlier: how long one takes depends on what else the machine does."""
    process = bake.start(folder, *more)
    time.sleep(bake.moment())
    was_at_work = process.poll() is None
    end_by(process, signal.SIGKILL)
    if not was_at_work and not more:
        bake.seconds *= 0.8
    return was_at_work


def control_of_files(bakes):
    """A whole bake of which one file is torn, and one whose frames are of another bake."""
    bake = bakes[0]
    folder = bake.empty_folder()
    shutil.copytree(bake.folder_of_whole, folder, dirs_exist_ok=True)
    bake.hold_whole(folder)
    path = os.path.join(folder, max(bake.whole, key=bake.whole.get))
    with open(path, "r+b") as file:
        file.truncate(os.path.getsize(path) // 2)
    must_be_found(lambda: bake.hold_whole(folder), "half a file")
    if os.path.basename(path) == GROWING:
        must_be_found(lambda: hold_verified(folder), "frames that are missing")
    with open(path, "r+b") as file:
        file.write(b"?")
    must_be_found(lambda: bake.hold_published(folder), "another byte")
    shutil.rmtree(folder)


def control_of_going_on(bakes):
    """A bake that is cut off, and loses its checkpoint, begins anew; and one that loses a file."""
    bake = bakes[0]
    folder = bake.empty_folder()
    shutil.copytree(bake.folder_of_whole, folder, dirs_exist_ok=True)
    with Kept(folder) as kept:
        os.remove(os.path.join(folder, "checkpoint"))
        must_be_found(kept.hold_still_there, "a checkpoint that is lost")
        done = bake.run(folder, "--resume")
        hold(done.returncode == DONE, done.stderr)
        bake.hold_whole(folder)
        must_be_found(kept.hold_gone_on, "a bake that begins anew")
    with Kept(folder) as kept:
        os.remove(os.path.join(folder, "surface.pc2"))
        must_be_found(kept.hold_still_there, "a file that is lost")
    shutil.rmtree(folder)
