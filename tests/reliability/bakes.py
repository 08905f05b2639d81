"""Bakes that the rows of reliability.py disturb, and what an undisturbed one of them leaves."""

import json
import os
import random
import shutil
import signal
import subprocess
import tempfile
import time

PROGRAM = os.path.abspath(os.environ.get("FASCICLE_PROGRAM", "fascicle"))
# Files that say when and how a bake ran; all others have the same bytes whatever happened on the way.
OF_ITS_RUN = ("manifest.json", "checkpoint")
UNFINISHED = (".part", ".tmp")
# Grows frame by frame under its own name; the checkpoint says how far it counts.
GROWING = "frames.fascicle"

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


def files(folder):
    """{path below the folder: bytes} of what is published, but for what says how the bake ran."""
    found = {}
    for parent, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(parent, name)
            if name in OF_ITS_RUN or name.endswith(UNFINISHED):
                continue
            with open(path, "rb") as file:
                found[os.path.relpath(path, folder)] = file.read()
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
        return {**os.environ, "FASCICLE_CACHE_DIR": self.cache, **more}

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
                whole = whole[:len(content)]
            hold(content == whole, "%s/%s: has other bytes" % (folder, name))

    def hold_whole(self, folder):
        self.hold_published(folder)
        missing = set(self.whole) - set(files(folder))
        hold(not missing, "%s: lacks %s" % (folder, ", ".join(sorted(missing))))
        size = os.path.getsize(os.path.join(folder, GROWING))
        hold(size == len(self.whole[GROWING]), folder + ": frames are missing")
        hold(manifest(folder)["position_hashes"] == self.hashes, folder + ": other position hashes")

    def resume(self, folder, *more):
        done = self.run(folder, "--resume", *more)
        hold(done.returncode == DONE, "%s: --resume ended with %d: %s" % (folder, done.returncode, done.stderr))
        self.hold_whole(folder)


def end_by(process, number):
    """The signal to the process and its children; it may be over."""
    try:
        os.killpg(process.pid, number)
    except ProcessLookupError:
        pass
    process.communicate()


def small_bakes():
    """A bar with a file a frame, a character whose body is kept, and one whose body is built in every run."""
    character = ["crouch", "--set", "character.resolution=0.12", "--set", "motion.hold=0.0", "--end", "0.3"]
    return [Bake("bar", ["bar-hang-none", "--end", "3", "--format", "pc2,obj"]),
            Bake("bear", [*character, "--format", "pc2,glb"]),
            Bake("built-bear", [*character, "--format", "abc"], keeps_cache=False)]


def killed_at_work(bake, folder, *more):
    """Starts it and kills it at a random moment; whether it was still at work. Where a bake from the start was over
    before, the next moments are earlier: how long one takes depends on what else the machine does."""
    process = bake.start(folder, *more)
    time.sleep(bake.moment())
    was_at_work = process.poll() is None
    end_by(process, signal.SIGKILL)
    if not was_at_work and not more:
        bake.seconds *= 0.8
    return was_at_work
