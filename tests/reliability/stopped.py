"""SIGTERM and SIGINT to bakes, and to one bake of a batch."""

import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time

from bakes import (DEVICE, DONE, INTERRUPTED, PROGRAM, Broken, control_of_files, control_of_going_on, end_by, files,
                   frame_of_checkpoint, hold, manifest, must_be_found)
from killed import PHASES, phase_of, stamp

PATIENCE = 120.0  # s, for what takes a moment on an idle machine
AT_ONCE = 2.0  # s
# Frames after the last written one: one being written, one queued behind it, one being solved and one already
# requested. Only the frame being solved is waited for.
MOST_AHEAD = 4
# Each frame takes seconds.
SLOW = ["bar-hang-none", "--set", "bar.vertices=[60,50,50]", "--set", "solver.substeps=1000", "--end", "0.2",
        "--device", "cpu", "--threads", "1"]
IGNORANT = "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); print(flush=True); time.sleep(30)"
TWICE = 4  # one bake in this many gets two signals
PHASES_AT_WORK = PHASES[:-1]  # a bake has no export


def ended_within(process, seconds):
    """Waits for the process to exit and returns its stderr; kills it if it takes too long."""
    try:
        return process.communicate(timeout=seconds)[1]
    except subprocess.TimeoutExpired:
        end_by(process, signal.SIGKILL)
        raise Broken("it is still running %.0f s after a signal" % seconds) from None


def stand_still(process):
    """Pauses the process, so that its files cannot change before the next signal. False if it has exited."""
    try:
        os.kill(process.pid, signal.SIGSTOP)
    except ProcessLookupError:
        return False
    seen = os.waitid(os.P_PID, process.pid, os.WSTOPPED | os.WEXITED | os.WNOWAIT)
    return seen.si_code == os.CLD_STOPPED


def hold_near(checkpoint, last_written, folder):
    """The checkpoint is at a frame that was in progress at the signal."""
    hold(checkpoint is not None and last_written <= checkpoint <= last_written + MOST_AHEAD,
         "%s: frame %d was written at the signal, but the checkpoint is at %s" % (folder, last_written, checkpoint))
    return checkpoint - last_written


def hold_stopped(bake, status, phase, written):
    """One signal ends a bake with 75, unless all of its frames were in progress or written."""
    is_late = phase == PHASES_AT_WORK[-1] or written + MOST_AHEAD >= len(bake.hashes)
    hold(status == INTERRUPTED or status == DONE and is_late,
         "%s: signalled at frame %d (%s), but it exited with %d" % (bake.name, written, phase, status))


def signalled(bake, number, is_twice, frames_late=0):
    """(exit status, phase, frames from the last written one at the signal to the checkpoint or None, folder). As a
    control, the signal can come `frames_late` frames after the count."""
    folder = bake.empty_folder()
    before = stamp(folder)
    process = bake.start_listening(folder)
    time.sleep(bake.moment() if not frames_late else 0.0)
    while frames_late and bake.frames_in(folder) == 0:
        time.sleep(0.0005)
    if not stand_still(process):
        text = ended_within(process, PATIENCE)
        hold(process.returncode == DONE, "%s: exited with %d: %s" % (folder, process.returncode, text))
        return DONE, None, None, folder
    phase, written = phase_of(bake, folder, before), bake.frames_in(folder)
    if frames_late:
        process.send_signal(signal.SIGCONT)
        while bake.frames_in(folder) < written + frames_late and process.poll() is None:
            time.sleep(0.0005)
    process.send_signal(number)
    process.send_signal(signal.SIGCONT)
    if is_twice:
        process.send_signal(number)
    text = ended_within(process, PATIENCE)
    # The second signal may arrive after the first one's handling is over.
    wanted = (DONE, INTERRUPTED, -number) if is_twice else (DONE, INTERRUPTED)
    hold(process.returncode in wanted,
         "%s: after signal %d it exited with %d: %s" % (folder, number, process.returncode, text))
    if not is_twice:
        hold_stopped(bake, process.returncode, phase, written)
    ahead = None
    if process.returncode == INTERRUPTED and written > 0:
        said = manifest(folder)["status"]
        hold(said == "interrupted", "%s: interrupted, but the manifest says %s" % (folder, said))
        ahead = hold_near(frame_of_checkpoint(folder), written - 1, folder)
    return process.returncode, phase, ahead, folder


def control_of_signals(bake):
    process = subprocess.Popen([sys.executable, "-c", IGNORANT], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               text=True, start_new_session=True)
    process.stdout.readline()
    process.send_signal(signal.SIGTERM)
    must_be_found(lambda: ended_within(process, 1.0), "a program that ignores SIGTERM")

    def late():
        # A bake that ends before it is paused shows nothing.
        for _ in range(20):
            _, phase, _, folder = signalled(bake, signal.SIGTERM, False, frames_late=MOST_AHEAD + 20)
            if phase is not None:
                return
            shutil.rmtree(folder)

    must_be_found(late, "a bake that continues for twenty frames")

    def deaf():
        folder = bake.empty_folder()
        process = bake.start_listening(folder)
        text = ended_within(process, PATIENCE)
        hold(process.returncode == DONE, text)
        shutil.rmtree(folder)
        hold_stopped(bake, process.returncode, PHASES_AT_WORK[0], 0)

    must_be_found(deaf, "a bake that ends as if no signal had come")


def processor_seconds(process):
    with open("/proc/%d/stat" % process.pid) as file:
        of = file.read().rpartition(")")[2].split()
    return (int(of[11]) + int(of[12])) / os.sysconf("SC_CLK_TCK")


def is_pending(process, number):
    """Whether a sent signal is still pending: a second one of the same kind would be lost."""
    with open("/proc/%d/status" % process.pid) as file:
        found = re.search(r"^ShdPnd:\s*(\w+)", file.read(), re.MULTILINE)
    return found is not None and bool(int(found.group(1), 16) & 1 << (number - 1))


def second_signal(bake, number, root):
    """Seconds to exit after a second signal, sent while the first one still waits for a frame."""
    folder = os.path.join(root, "slow")
    process = subprocess.Popen([PROGRAM, "bake", *SLOW, "-o", folder], stdout=subprocess.DEVNULL,
                               stderr=subprocess.PIPE, text=True, env=bake.environment(), start_new_session=True)
    patience = time.monotonic() + PATIENCE
    while frame_of_checkpoint(folder) is None and process.poll() is None:
        hold(time.monotonic() < patience, "the slow bake does not start")
        time.sleep(0.01)
    # After the checkpoint of frame 0 it soon solves the next frame.
    begin = processor_seconds(process)
    while process.poll() is None and processor_seconds(process) < begin + 0.5:
        time.sleep(0.01)
    process.send_signal(number)
    while process.poll() is None and is_pending(process, number):
        time.sleep(0.01)
    time.sleep(0.3)
    hold(process.poll() is None, "frames of the slow bake are too short: the first signal ended it")
    begin = time.monotonic()
    process.send_signal(number)
    text = ended_within(process, AT_ONCE)
    seconds = time.monotonic() - begin
    hold(process.returncode == -number, "a second signal %d: exit status %d: %s" % (number, process.returncode, text))
    done = subprocess.run([PROGRAM, "verify", folder], capture_output=True, text=True)
    hold(done.returncode == DONE, "%s: verify after two signals: %s" % (folder, done.stderr))
    shutil.rmtree(folder)
    return seconds


class Batch:
    """A batch of four bars, two at once, of which one bake alone gets a signal."""

    def __init__(self, bake):
        self.root, self.environment = bake.root, bake.environment()
        self.jobs = os.path.join(bake.root, "stopped-jobs.toml")
        with open(self.jobs, "w") as file:
            file.write('format = ["pc2"]\n[job.bar]\nscene = "bar-hang-none"\nset = ["scene.end=10.0"]\n'
                       '[job.bar.vary]\n"layers.body.alpha" = [0.3, 0.4, 0.5, 0.6]\n')
        whole = os.path.join(bake.root, "stopped-whole")
        self.run(whole)
        self.whole = self.files_in(whole)

    def command(self, folder, *more):
        return [PROGRAM, "batch", self.jobs, "--device", DEVICE, "--at-once", "2", "-o", folder, *more]

    def run(self, folder, *more):
        done = subprocess.run(self.command(folder, *more), env=self.environment, capture_output=True, text=True)
        hold(done.returncode == DONE, "%s: exited with %d: %s" % (folder, done.returncode, done.stderr))

    @staticmethod
    def files_in(folder):
        return {name: content for name, content in files(folder).items() if os.sep in name and name[0] != "."}

    def child_signalled(self, number):
        """Returns whether the signal stopped a child; the batch carries on without it."""
        folder = os.path.join(self.root, "stopped-batch")
        process = subprocess.Popen(self.command(folder), env=self.environment, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, text=True, start_new_session=True)
        # Children handle signals once their bake has started.
        while not (at_work := self.at_work(process)) and process.poll() is None:
            time.sleep(0.001)
        time.sleep(random.uniform(0.0, 0.2))
        for child in at_work[:1]:
            try:
                os.kill(child, number)
            except ProcessLookupError:
                pass
        text = ended_within(process, PATIENCE)
        with open(os.path.join(folder, "batch.json")) as file:
            states = [job["status"] for job in json.load(file)["jobs"]]
        stopped = states.count("interrupted")
        hold(sorted(set(states)) in (["done"], ["done", "interrupted"]) and stopped <= 1,
             "%s: after a signal to one child, the jobs are %s" % (folder, states))
        hold(process.returncode == (INTERRUPTED if stopped else DONE),
             "%s: one of its bakes got signal %d, and the batch exited with %d: %s" % (
                 folder, number, process.returncode, text))
        hold(not stopped or re.search(r"bar-0\.\d on \S+: interrupted", text),
             "%s: it does not name the interrupted job: %s" % (folder, text))
        self.run(folder, "--resume")
        hold(self.files_in(folder) == self.whole, folder + ": bytes differ")
        shutil.rmtree(folder)
        return bool(stopped)

    @staticmethod
    def at_work(process):
        """PIDs of child bakes that handle SIGTERM."""
        found = []
        try:
            with open("/proc/%d/task/%d/children" % (process.pid, process.pid)) as file:
                children = file.read().split()
            for child in children:
                with open("/proc/%s/cmdline" % child, "rb") as file:
                    is_bake = b"\0bake\0" in file.read()
                with open("/proc/%s/status" % child) as file:
                    caught = re.search(r"SigCgt:\s*(\w+)", file.read())
                if is_bake and caught and int(caught.group(1), 16) & 1 << (signal.SIGTERM - 1):
                    found.append(int(child))
        except (FileNotFoundError, ProcessLookupError):
            pass
        return found


def stopped(bakes, count):
    """SIGTERM or SIGINT arrives at a random moment of a bake; one bake in four gets two. SIGSTOP holds the bake while
    its frames are counted and the signal is sent, so that no frame slips in between. The checkpoint must be at a frame
    that was then in progress: only the frame being solved is waited for, but up to three more have been requested or
    wait to be written. A second signal ends a bake of
    very slow frames within 2 s. One bake of a batch gets a signal alone, and the others carry on."""
    control_of_files(bakes)
    control_of_going_on(bakes)
    control_of_signals(bakes[0])
    signals = (signal.SIGTERM, signal.SIGINT)
    phases, ended, twice, ahead, went_on = dict.fromkeys(PHASES_AT_WORK, 0), dict.fromkeys(signals, 0), 0, [], 0
    for k in range(count):
        bake = bakes[k % len(bakes)]
        number = signals[k // 2 % 2]
        status, phase, frames, folder = signalled(bake, number, k % TWICE == TWICE - 1)
        if phase is not None:
            phases[phase] += 1
            twice += k % TWICE == TWICE - 1
        ended[number] += status == INTERRUPTED
        ahead += [] if frames is None else [frames]
        bake.hold_counted(folder)
        went_on += bake.resume(folder)
        shutil.rmtree(folder)
    hold(count < 200 or all(phases.values()), "a phase had no signal: %s" % phases)
    hold(count < 40 or all(ended.values()), "a signal made no bake exit with 75: %s" % ended)
    seconds = [second_signal(bakes[0], signals[(k + 1) % 2], bakes[0].root) for k in range(max(1, count // 40))]
    batch = Batch(bakes[0])
    children = max(1, count // 20)
    alone = sum(batch.child_signalled(signals[k % 2]) for k in range(children))
    return "%d signals hit a bake at work (%s), %d of them twice; %d bakes exited with 75; checkpoints were at most " \
           "%d frames after the last frame written; a second signal ended %d slow bakes, in %.1f s at most; %d of %d " \
           "bakes of a batch stopped alone while the others carried on; each was resumed to the same bytes, %d from " \
           "a checkpoint" % (
               sum(phases.values()), ", ".join("%s %d" % pair for pair in phases.items()), twice,
               sum(ended.values()), max(ahead, default=0), len(seconds), max(seconds), alone, children, went_on)
