"""Disks that are full or broken, and limits on file size, during bakes, exports, renders and batches, and in the
cache."""

import errno
import functools
import json
import os
import random
import resource
import shutil
import subprocess
import sys

from bakes import (DONE, FAILED, GROWING, PROGRAM, control_of_files, control_of_going_on, digest, files, hold, manifest,
                   must_be_found)
from failing_calls import calls_in, count_of, counted_calls, plan
from killed import export_of

# A writer that carries on after a failed write if sys.argv[2] is "silent", and otherwise exits with the error.
SWALLOWS = """import os, sys
with open(sys.argv[1], "wb", buffering=0) as file:
    for _ in range(100):
        try:
            file.write(b"x" * 1000)
        except OSError as error:
            if sys.argv[2] != "silent":
                sys.exit(str(error))
"""


def hold_noticed(done, number, calls, error, what):
    """A failed call ends the program with the reason. Returns whether a call failed: the program may have made fewer
    calls than `number`."""
    if done.returncode == DONE:
        hold(calls < number, "%s: call %d of %d failed (%s) but was not reported" % (
            what, number, calls, os.strerror(error)))
        return False
    hold(done.returncode == FAILED, "%s: exited with %d: %s" % (what, done.returncode, done.stderr))
    hold(os.strerror(error) in done.stderr, "%s: the message does not give the reason: %s" % (what, done.stderr))
    return True


def hold_marked(folder, error):
    """The manifest, if there is one, says that the bake failed, and why. Returns whether there is one."""
    said = manifest(folder)
    if said is None:
        return False
    hold(said["status"] == "failed" and os.strerror(error) in said["message"],
         "%s: the manifest says %s: %s" % (folder, said["status"], said["message"]))
    return True


class BakeThere:
    """A bake into a failing folder."""

    def __init__(self, bake):
        self.bake, self.name = bake, bake.name

    def folder(self):
        return self.bake.empty_folder()

    def run(self, folder, **more):
        return self.bake.run(folder, **more)

    def hold_published(self, folder, error):
        self.bake.hold_counted(folder)
        if error:
            hold_marked(folder, error)

    def finish(self, folder):
        self.bake.resume(folder)


class ExportThere:
    """An export over the files of an older one."""
    name = "export"

    def __init__(self, bake):
        self.export = export_of(bake)

    def folder(self):
        return self.export.folder_of_older()

    def run(self, folder, **more):
        return subprocess.run(self.export.command(folder, "--overwrite"), capture_output=True, text=True,
                              env={**os.environ, **more})

    def hold_published(self, folder, _):
        self.export.hold_whole_files(folder)

    def finish(self, folder):
        self.export.finish(folder)


class RenderThere:
    """A render of one picture per frame."""
    name = "render"

    def __init__(self, bake):
        self.bake = bake
        folder = bake.empty_folder()
        done = self.run(folder)
        hold(done.returncode == DONE, done.stderr)
        self.whole = files(folder)
        shutil.rmtree(folder)

    def folder(self):
        return self.bake.empty_folder()

    def run(self, folder, *more, **environment):
        return subprocess.run([PROGRAM, "render", self.bake.folder_of_whole, "--size", "160x120", "-o",
                               os.path.join(folder, "pictures"), *more],
                              capture_output=True, text=True, env={**os.environ, **environment})

    def hold_published(self, folder, _):
        for name, content in files(folder).items():
            hold(content == self.whole.get(name), "%s/%s: bytes differ" % (folder, name))

    def finish(self, folder):
        done = self.run(folder, "--overwrite")
        hold(done.returncode == DONE, "%s: the next render exited with %d: %s" % (folder, done.returncode, done.stderr))
        hold(files(folder) == self.whole, folder + ": pictures differ")


class BatchThere:
    """A batch of two bars; a call fails in the batch process and in each bake."""
    name = "batch"

    def __init__(self, bake):
        self.bake = bake
        self.jobs = os.path.join(bake.root, "disk-jobs.toml")
        with open(self.jobs, "w") as file:
            file.write('format = ["pc2"]\n[job.bar]\nscene = "bar-hang-none"\nset = ["scene.end=1.0"]\n'
                       '[job.bar.vary]\n"layers.body.alpha" = [0.3, 0.6]\n')
        folder = bake.empty_folder()
        done = self.run(folder)
        hold(done.returncode == DONE, done.stderr)
        self.folder_of_whole, self.whole = folder, self.files_in(folder)

    def folder(self):
        return self.bake.empty_folder()

    def run(self, folder, *more, **environment):
        return subprocess.run([PROGRAM, "batch", self.jobs, "--device", "cpu", "-o", folder, *more],
                              capture_output=True, text=True, env=self.bake.environment(**environment))

    @staticmethod
    def files_in(folder):
        return {name: content for name, content in files(folder).items() if os.sep in name and name[0] != "."}

    def hold_published(self, folder, _):
        for name, content in self.files_in(folder).items():
            whole = self.whole.get(name)
            if name.endswith(GROWING):
                whole = digest(os.path.join(self.folder_of_whole, name), content[0])
            hold(content == whole, "%s/%s: bytes differ" % (folder, name))
        if os.path.exists(os.path.join(folder, "batch.json")):
            done = subprocess.run([PROGRAM, "batch", "status", folder], capture_output=True, text=True)
            hold("damaged" not in done.stderr, "%s: batch.json: %s" % (folder, done.stderr))

    def finish(self, folder):
        done = self.run(folder, "--resume")
        hold(done.returncode == DONE, "%s: --resume exited with %d: %s" % (folder, done.returncode, done.stderr))
        hold(self.files_in(folder) == self.whole, folder + ": bytes differ")


class CacheThere:
    """A bake with a failing cache: it finishes anyway and leaves no truncated entry."""
    name = "cache"

    def __init__(self, bake):
        self.bake = bake
        self.whole = self.sizes_in(bake.cache)
        self.out = os.path.join(bake.root, "of-failing-cache")

    @staticmethod
    def sizes_in(folder):
        return {name: content[0] for name, content in files(folder).items()}

    def folder(self):
        return self.bake.empty_folder()

    def run(self, folder, **more):
        """`folder` is the cache."""
        shutil.rmtree(self.out, ignore_errors=True)
        return self.bake.run(self.out, FASCICLE_CACHE_DIR=folder, **more)

    def hold_published(self, folder, _):
        self.bake.hold_whole(self.out)
        # Entries hold their build time, so only sizes can be compared.
        for name, content in files(folder).items():
            hold(content[0] == self.whole.get(name), "%s/%s: incomplete" % (folder, name))

    def finish(self, folder):
        done = self.run(folder)
        hold(done.returncode == DONE, "%s: the next bake exited with %d: %s" % (folder, done.returncode, done.stderr))
        self.bake.hold_whole(self.out)
        hold(self.sizes_in(folder) == self.whole, folder + ": entries differ")
        shutil.rmtree(self.out)


def calls_of(of):
    folder = of.folder()
    calls = counted_calls(functools.partial(of.run, folder), folder)
    shutil.rmtree(folder)
    return calls


def control_of_errors(root):
    """Controls: a writer that ignores a full disk, and one that reports it."""
    path = os.path.join(root, "swallowed")
    for how in ("silent", "aloud"):
        done = subprocess.run([sys.executable, "-c", SWALLOWS, path, how], capture_output=True, text=True,
                              env={**os.environ, **plan(path, 50, errno.ENOSPC, "from")})
        calls = calls_in(path)
        hold(calls >= 50 and os.path.getsize(path) == 49000, "the control never hit the full disk: %s" % done.stderr)
        if how == "silent":
            must_be_found(lambda: hold_noticed(done, 50, calls, errno.ENOSPC, path), "a swallowed error")
        else:
            hold(hold_noticed(done, 50, calls, errno.ENOSPC, path), "the control exited with 0")


def fail_one(of, calls, is_once):
    """Fails one random call, or that call and all after it. Returns whether a call failed."""
    folder = of.folder()
    number, error = random.randint(1, calls), errno.EIO if is_once else errno.ENOSPC
    done = of.run(folder, **plan(folder, number, error, "once" if is_once else "from"))
    what = "%s, %s" % (of.name, folder)
    made = calls_in(folder) if os.path.exists(count_of(folder)) else 0
    if isinstance(of, CacheThere):  # the cache is optional: the bake must still finish
        hold(done.returncode == DONE, "%s: exited with %d: %s" % (what, done.returncode, done.stderr))
        has_failed = made >= number
    else:
        has_failed = hold_noticed(done, number, made, error, what)
    # Where all later calls fail, the manifest cannot be written either.
    of.hold_published(folder, error if is_once and has_failed else 0)
    of.finish(folder)
    shutil.rmtree(folder)
    return has_failed


def fill_tmpfs(bake, size):
    """A bake on a tmpfs of `size` bytes, then --resume with more space. None if no tmpfs can be mounted, else whether
    the full one had a manifest."""
    folder = bake.empty_folder()
    options = "size=%d" % size
    if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", folder],
                                           capture_output=True).returncode != 0:
        shutil.rmtree(folder)
        return None
    try:
        done = bake.run(folder)
        hold(hold_noticed(done, 1, 1, errno.ENOSPC, folder), folder + ": the small disk was large enough")
        bake.hold_counted(folder)
        is_marked = hold_marked(folder, errno.ENOSPC)
        subprocess.run(["mount", "-o", "remount,size=64m", folder], check=True, capture_output=True)
        bake.resume(folder)
    finally:
        subprocess.run(["umount", folder], check=True)
    os.rmdir(folder)
    return is_marked


def limit_files(bake):
    """A bake under a random limit on file size (`ulimit -f`), as farms have them. Returns whether it had a manifest."""
    folder = bake.empty_folder()
    most = random.randint(4096, max(bake.whole.values())[0] - 1)
    done = subprocess.run(bake.command(folder), capture_output=True, text=True, env=bake.environment(),
                          preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most)))
    hold_noticed(done, 1, 1, errno.EFBIG, "%s, files limited to %d bytes" % (folder, most))
    bake.hold_counted(folder)
    is_marked = hold_marked(folder, errno.EFBIG)
    bake.resume(folder)
    shutil.rmtree(folder)
    return is_marked


def control_of_marks(bake):
    """Controls: manifests of a bake that completed, and of one that failed for another reason."""
    must_be_found(lambda: hold_marked(bake.folder_of_whole, errno.ENOSPC), "a manifest that names no failure")
    folder = bake.empty_folder()
    with open(os.path.join(folder, "manifest.json"), "w") as file:
        json.dump({"status": "failed", "message": os.strerror(errno.EIO)}, file)
    hold(hold_marked(folder, errno.EIO), "a manifest is not read")
    must_be_found(lambda: hold_marked(folder, errno.ENOSPC), "a manifest with another reason")
    shutil.rmtree(folder)


def disk_fails(bakes, count):
    """The k-th call that changes a file fails, either alone (an I/O error) or with all calls after it (a full disk). It
    fails in a bake, an export, a render, a batch, and in the cache of a bake, which must then finish without its cache.
    Bakes also run on a tmpfs that is too small and under a limit on file size (`ulimit -f`). The manifest says that the
    bake failed, and why, unless all calls from the k-th on fail."""
    control_of_files(bakes)
    control_of_going_on(bakes)
    control_of_errors(bakes[0].root)
    control_of_marks(bakes[0])
    # The slowest come last: the short form has no time for them.
    places = [BakeThere(bakes[0]), RenderThere(bakes[1]), BatchThere(bakes[0]), "tmpfs", "limit", CacheThere(bakes[1]),
              ExportThere(bakes[1]), BakeThere(bakes[1]), BakeThere(bakes[2])]
    calls, failed = {}, {place.name: 0 for place in places if not isinstance(place, str)}
    beyond = tmpfs = limits = marked = 0
    is_mountable = True
    for k in range(count):
        place = places[k % len(places)]
        if place == "tmpfs":
            is_marked = fill_tmpfs(bakes[0], random.randint(1, 8) << 18) if is_mountable else None
            is_mountable = is_marked is not None
            tmpfs += is_mountable
            marked += bool(is_marked)
        elif place == "limit":
            marked += limit_files(bakes[limits % 2])
            limits += 1
        else:
            if place.name not in calls:
                calls[place.name] = calls_of(place)
            if fail_one(place, calls[place.name], k // len(places) % 2 == k % 2):
                failed[place.name] += 1
            else:
                beyond += 1
    text = "%d runs: %d calls failed (%s), and each outside the cache ended its program with 1 and the reason; %d " \
           "were set after the last call of their run; %d tmpfs were full%s; %d limits were hit; of these, %d had a " \
           "manifest, which gave the reason; all were resumed to the same bytes"
    return text % (count, sum(failed.values()), ", ".join("%s %d" % pair for pair in failed.items()), beyond, tmpfs,
                   "" if is_mountable else " (NOT TESTED: no tmpfs can be mounted here)", limits, marked)
