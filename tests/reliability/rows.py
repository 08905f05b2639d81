"""The rows of the table, one function each. A row disturbs bakes `count` times and compares the results with an
undisturbed bake. It returns its figure, or raises Broken if a check fails. Each row has controls: the same checks must
fail for a careless program."""

import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
import typing

from bakes import (BAD_INPUT, DEVICE, DONE, INTERRUPTED, PROGRAM, a_kept_body, control_of_files, hold, manifest,
                   must_be_found)
from company import clashes, drivers, load
from device_faults import device_faults
from disk import disk_fails
from durable import durable
from hostile_names import names
from hostile_parameters import parameters
from hostile_surfaces import surfaces
from killed import killed
from layers import layers
from memory import memory
from outside import outside
from stopped import PATIENCE, stand_still, stopped


HEAD_BYTES = 128  # the first bytes of a file, including all of its header
HEAD_OF_FRAMES = 104  # bytes before the first frame (host/bake/read_frame_cache.h)


def in_turns(bakes, count):
    for k in range(count):
        yield bakes[k % len(bakes)]


def resumed(bakes, count):
    """A bake is resumed from a random frame (nine times in ten of a bar, else of a character), with another end, other
    formats, another number of threads and another device: a CPU level or, where there is one, Vulkan."""
    control_of_files(bakes)
    devices = subprocess.run([PROGRAM, "devices"], capture_output=True, text=True, check=True).stdout
    found = re.search(r"^ +levels +(.*)$", devices, re.MULTILINE)
    hold(found, "the CPU lists no levels")
    every_device = ["cpu:" + level for level in found.group(1).split(", ")]
    vulkan = DEVICE if DEVICE.startswith("vulkan:") else "vulkan:0"
    if vulkan in devices:
        every_device += [vulkan] * len(every_device)
    of_vulkan = 0
    for k in range(count):
        bake = bakes[1 if k % 10 == 9 else 0]
        key, value = ("layers.body.alpha", "0.9") if bake is bakes[0] else ("layers.fat.youngs_modulus", "2e4")
        frames = len(bake.hashes) - 1
        end = float(bake.arguments[bake.arguments.index("--end") + 1])
        folder = bake.empty_folder()
        at = random.randint(1, frames - 1)
        first, formats = list(bake.arguments), bake.arguments.index("--format") + 1
        first[first.index("--end") + 1] = repr(end * at / frames)
        # Only `vtu` cannot be added later: it holds velocities, which the frames lack.
        kept = random.sample(all_of := first[formats].split(","), random.randint(1, len(all_of)))
        first[formats] = ",".join(name for name in all_of if name in kept or name == "vtu")
        before, after = random.choice(every_device), random.choice(every_device)
        of_vulkan += before != after and vulkan in (before, after)
        command = [PROGRAM, "bake", *first, "--device", before, "--threads", "1", "-o", folder]
        done = subprocess.run(command, capture_output=True, text=True, env=bake.environment())
        hold(done.returncode == DONE, "%s: %s" % (" ".join(command), done.stderr))
        refused = bake.run(folder, "--resume", "--set", "%s=%s" % (key, value))
        hold(refused.returncode == BAD_INPUT and "the key %s was" % key in refused.stderr,
             "%s: a changed stiffness was not refused: %s" % (folder, refused.stderr))
        bake.resume(folder, "--device", after, "--threads", str(1 + k % 3))
        shutil.rmtree(folder)
    return "%d of %d have the bytes of an uninterrupted bake, %d of them moved from the CPU to Vulkan or back; a " \
           "changed stiffness is refused by name%s" % (
               count, count, of_vulkan, "" if vulkan in devices else " (NOT TESTED: there is no Vulkan device)")


def processes_in(folder):
    """PIDs of processes whose arguments name this folder."""
    found = []
    for name in os.listdir("/proc"):
        if not name.isdigit() or int(name) == os.getpid():
            continue
        try:
            with open("/proc/%s/cmdline" % name, "rb") as file:
                if folder.encode() in file.read():
                    found.append(int(name))
        except OSError:
            pass
    return found


def batches_stopped(bakes, count):
    """SIGTERM, SIGINT or SIGKILL ends a batch of four bakes, of which two run at a time. If bakes had still to be
    started, SIGTERM and SIGINT end it with 75. None of its child processes may survive it."""
    root = bakes[0].root
    jobs = os.path.join(root, "jobs.toml")
    with open(jobs, "w") as file:
        file.write('format = ["pc2"]\n[job.bar]\nscene = "bar-hang-none"\nset = ["scene.end=3.0"]\n'
                   '[job.bar.vary]\n"layers.body.alpha" = [0.3, 0.4, 0.5, 0.6]\n')
    environment = bakes[0].environment()
    command = [PROGRAM, "batch", jobs, "--device", DEVICE, "--at-once", "2", "-o"]

    def files_of(folder):
        found = {}
        for name in sorted(os.listdir(folder)):
            path = os.path.join(folder, name)
            if os.path.isdir(path) and not name.startswith("."):
                with open(os.path.join(path, "surface.pc2"), "rb") as file:
                    found[name] = file.read()
        hold(len(found) == 4, folder + ": %d bakes" % len(found))
        return found

    def hold_ended(number, status, complete, folder):
        """If fewer than two bakes were complete, one had not been started; returns whether that is so."""
        has_work = complete < 2
        wanted = (-number,) if number == signal.SIGKILL else (INTERRUPTED,)
        hold(status in (wanted if has_work else (*wanted, DONE)),
             "%s: after signal %d, with %d bakes complete, the batch exited with %d" % (
                 folder, number, complete, status))
        return has_work

    def complete_in(folder):
        bakes_of = (os.path.join(folder, name) for name in os.listdir(folder))
        said = [manifest(path) for path in bakes_of if os.path.isdir(path)]
        return sum(one is not None and one["status"] == "complete" for one in said)

    whole = os.path.join(root, "whole-batch")
    begin = time.monotonic()
    subprocess.run([*command, whole], env=environment, check=True, capture_output=True)
    seconds = time.monotonic() - begin
    expected = files_of(whole)
    hold(complete_in(whole) == 4, "complete bakes are not counted")
    must_be_found(lambda: hold_ended(signal.SIGTERM, DONE, 0, whole), "a batch that ends as if no signal had come")
    left = os.path.join(root, "left")
    script = "import time; print(flush=True); time.sleep(60)"
    child = subprocess.Popen([sys.executable, "-c", script, left], stdout=subprocess.PIPE)
    child.stdout.readline()  # before exec() has finished, the arguments are not visible
    must_be_found(lambda: hold(not processes_in(left), "a child is running"), "a child that is running")
    child.kill()
    child.communicate()
    at_work = 0
    for k in range(count):
        folder = os.path.join(root, "batch-%d" % k)
        number = (signal.SIGTERM, signal.SIGINT, signal.SIGKILL)[k % 3]
        process = subprocess.Popen([*command, folder], env=environment, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL, start_new_session=True)
        while not os.path.exists(os.path.join(folder, "batch.json")):  # its signal handlers are installed by then
            time.sleep(0.001)
        time.sleep(random.uniform(0.0, seconds))
        complete = 4
        if stand_still(process):  # a batch that stands still starts no bake while they are counted
            complete = complete_in(folder)
            process.send_signal(number)
            process.send_signal(signal.SIGCONT)
        at_work += hold_ended(number, process.wait(), complete, folder)
        patience = time.monotonic() + PATIENCE
        while processes_in(folder) and time.monotonic() < patience:
            time.sleep(0.02)
        hold(not processes_in(folder), folder + ": a child outlived the batch")
        done = subprocess.run([*command, folder, "--resume"], env=environment, capture_output=True, text=True)
        hold(done.returncode == DONE, "%s: --resume exited with %d: %s" % (folder, done.returncode, done.stderr))
        hold(files_of(folder) == expected, folder + ": bytes differ")
        shutil.rmtree(folder)
    return "%d batches, %d of which had bakes yet to start; no child survived, and each batch was resumed to the " \
           "same bytes" % (count, at_work)


def damages(content, count):
    """(damaged content, description, flipped byte or None): one flipped bit in each of the first bytes, cuts at
    multiples of 4 KiB, then flips at random."""
    size = len(content)

    def flipped(at, bit):
        return content[:at] + bytes([content[at] ^ (1 << bit)]) + content[at + 1:], "bit %d of byte %d" % (bit, at), at

    def cut(at):
        return content[:at], "the end at byte %d" % at, None

    head = [(at, at % 8) for at in range(min(size, HEAD_BYTES))]
    ends = list(range(0, size, 4096))
    few = max(1, 2 * count // 5)  # limits the first bytes to fewer than 128 only if count is below 320
    for at, bit in random.sample(head, min(len(head), few)):
        yield flipped(at, bit)
    for at in random.sample(ends, min(len(ends), few)):
        yield cut(at)
    for _ in range(max(0, count - min(len(head), few) - min(len(ends), few))):
        yield flipped(random.randrange(size), random.randrange(8))


def content_of(path):
    with open(path, "rb") as file:
        return file.read()


def same_json(one, other):
    """Compares the values: a flipped bit may turn the `e` of an exponent into an `E`."""
    try:
        return json.loads(one) == json.loads(other)
    except ValueError:
        return False


def damage(path, count, check):
    """Runs `check` on `count` damaged versions of a file, one at a time; returns how many."""
    with open(path, "rb") as file:
        content = file.read()
    done = 0
    for left, what, at in damages(content, count):
        if path.endswith(".json") and same_json(left, content):
            continue
        with open(path, "wb") as file:
            file.write(left)
        check("%s: %s" % (path, what), at)
        done += 1
        with open(path, "wb") as file:
            file.write(content)
    return done


def damaged(bakes, count):
    """One bit of one of our own files is flipped (in each of the first 128 bytes, then at random), or the file is cut
    off at a multiple of 4 KiB. `fascicle verify` must detect it in the files of a bake, and `fascicle batch status` in
    those of a batch. Every tenth damaged bake is also exported and resumed, which must be refused. A bake must never
    use a damaged cache entry: it builds the body anew and replaces the entry."""
    bake, kept = bakes[0], a_kept_body()
    kept.prepare(bake.root)
    folder = bake.empty_folder()
    shutil.copytree(bake.folder_of_whole, folder, dirs_exist_ok=True)

    def ended(command, wanted, word="", what="undamaged"):
        done = subprocess.run([PROGRAM, *command], capture_output=True, text=True)
        hold(done.returncode == wanted and word in done.stdout + done.stderr,
             "%s: %s exited with %d: %s" % (what, " ".join(command), done.returncode, done.stdout + done.stderr))

    found = {}
    ended(["verify", folder], DONE)
    must_be_found(lambda: damage(os.path.join(folder, "surface.pc2"), 4,
                                 lambda what, _: ended(["verify", folder], BAD_INPUT, what=what)),
                  "a file that verify does not read")
    shutil.copy(os.path.join(bake.folder_of_whole, "surface.pc2"), folder)
    frames = os.path.join(folder, "frames.fascicle")
    record = (os.path.getsize(frames) - HEAD_OF_FRAMES) // len(bake.hashes)

    def frame_is_named(what, at):
        in_frames = at is not None and at >= HEAD_OF_FRAMES
        word = "frame %d\n" % ((at - HEAD_OF_FRAMES) // record) if in_frames else "frames.fascicle"
        ended(["verify", folder], BAD_INPUT, word, what)

    longer = list(bake.arguments)
    longer[longer.index("--end") + 1] = "9"
    uses = {"export": ["export", folder, "--to", "obj", "-o", bake.root + "/damaged-export"],
            "resume": ["bake", *longer, "--device", "cpu", "-o", folder, "--resume"]}
    # A resumed bake writes the model anew, and an export needs no checkpoint.
    used_by = {"frames.fascicle": ("export", "resume"), "model.fascicle": ("export",), "checkpoint": ("resume",),
               "manifest.json": ("export", "resume")}
    used = 0
    for name in used_by:
        def check(what, at, name=name):
            nonlocal used
            if name == "frames.fascicle":
                frame_is_named(what, at)
            else:
                ended(["verify", folder], BAD_INPUT, name, what)
            if random.random() < 0.1:
                for use in used_by[name]:
                    ended(uses[use], BAD_INPUT, "fascicle: error: ", what)
                    used += 1

        found[name] = damage(os.path.join(folder, name), count // 5, check)
    ended(["verify", folder], DONE)

    jobs = os.path.join(bake.root, "damaged-jobs.toml")
    batch = os.path.join(bake.root, "damaged-batch")
    with open(jobs, "w") as file:
        file.write('[job.bar]\nscene = "bar-hang-none"\nset = ["scene.end=0.1"]\n')
    ended(["batch", jobs, "-o", batch], DONE)
    ended(["batch", "status", batch], DONE)
    found["batch.json"] = damage(os.path.join(batch, "batch.json"), count // 5,
                                 lambda what, _: ended(["batch", "status", batch], BAD_INPUT, "batch.json", what))

    entries = [os.path.join(kept.cache, name) for name in sorted(os.listdir(kept.cache)) if name.endswith(".entry")]
    whole = {entry: content_of(entry) for entry in entries}
    hold(len(entries) == 3, "the cache keeps not a body, a model and a start, but %d entries" % len(entries))

    def rebuilt(what, *changed):
        out = kept.empty_folder()
        done = kept.run(out, *changed)
        hold(done.returncode == DONE, "%s: %s" % (what, done.stderr))
        kept.hold_whole(out)
        shutil.rmtree(out)

    def replaced(what, entry):
        """The bake has the right bytes, and another entry in place of this one."""
        for other in entries:  # a kept model hides the kept body that it was made of
            if other != entry and os.path.exists(other):
                os.remove(other)
        before = content_of(entry)
        rebuilt(what)
        hold(os.path.exists(entry), what + ": no entry was kept")
        hold(content_of(entry) != before, "%s: the entry is still there" % what)

    must_be_found(lambda: rebuilt("another body", "--set", "character.resolution=0.13"), "a different body")
    for entry in entries:
        with open(entry, "wb") as file:
            file.write(whole[entry])
        must_be_found(lambda entry=entry: replaced("no damage", entry), "an entry that is used")
        what = damage(entry, max(1, 3 * count // 100), lambda what, _, entry=entry: replaced(what, entry))
        found["kept entries"] = found.get("kept entries", 0) + what
    return "%d of %d damages detected: %s; %d exports and resumed bakes of damaged files were refused" % (
        sum(found.values()), sum(found.values()), ", ".join("%s %d" % pair for pair in found.items()), used)


class Row(typing.NamedTuple):
    name: str
    title: str
    function: typing.Callable
    often: int  # for the page
    seldom: int  # in CI
    on_device: bool = False  # its bakes run on FASCICLE_DEVICE


ROWS = (
    Row("killed", "SIGKILL at random moments", killed, 1000, 2, True),
    Row("stopped", "SIGTERM and SIGINT at random moments", stopped, 400, 2, True),
    Row("durable", "Order of writes, syncs and renames", durable, 32, 16),
    Row("resumed", "Resuming from random frames with other settings", resumed, 200, 2, True),
    Row("batches", "Signals to a whole batch", batches_stopped, 60, 3, True),
    Row("disk", "Full disks and I/O errors", disk_fails, 200, 5, True),
    Row("damaged", "Flipped bits and truncated files", damaged, 12000, 20),
    Row("outside", "Sockets, files and programs outside the bake", outside, 16, 5),
    Row("surfaces", "Hostile surfaces", surfaces, 5000, 8),
    Row("values", "Hostile scene values", parameters, 10000, 10, True),
    Row("names", "Hostile names", names, 270, 2),
    Row("clashes", "Bakes that share a folder or a cache", clashes, 60, 1, True),
    Row("drivers", "Missing and broken Vulkan drivers and layers", drivers, 20, 4),
    Row("device", "Vulkan calls that fail", device_faults, 200, 1),
    Row("load", "Very long, many and large bakes", load, 10000, 100),
    Row("layers", "The Khronos validation layer", layers, 100, 1),
    Row("memory", "Valgrind", memory, 100, 1),
)
