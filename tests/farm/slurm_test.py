"""A batch on a real one-node Slurm gives the same bytes in every file as an undisturbed `fascicle batch`.

Meanwhile tasks are killed, requeued and preempted, the node is drained, and Slurm's daemons are restarted.
FASCICLE_PROGRAM names the program. Without Slurm the test is skipped, loudly; with FASCICLE_REQUIRE_SLURM=1 it fails.
FASCICLE_FARM_JOBS sets a longer batch than CI's, FASCICLE_FARM_TRANSCRIPT a file for the transcript (`./do farm` sets
both).
"""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import slurm_cluster

PROGRAM = os.environ.get("FASCICLE_PROGRAM", "fascicle")
JOBS = int(os.environ.get("FASCICLE_FARM_JOBS", "6"))
IS_LONG = JOBS >= 20
TRANSCRIPT = os.environ.get("FASCICLE_FARM_TRANSCRIPT")
# Long enough to catch a task while it runs. If that fails on a busy machine, the test starts over with longer bakes.
# Only late events are retried; a file with wrong bytes fails at once.
SECONDS_OF_A_BAKE = (1.5, 4.0, 8.0)
# Files of a bake that say when and how it ran.
OF_ITS_RUN = {"manifest.json", "checkpoint"}


def fascicle(*arguments, **more):
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, **more)


class Transcript:
    """The commands and their output, as a person would see them, without this machine's folders."""

    def __init__(self, folder):
        self.folder = folder
        self.lines = []

    def add(self, command, output, keep=None):
        lines = output.rstrip().splitlines()
        if keep is not None and len(lines) > 2 * keep:
            lines = lines[:keep] + ["  ..."] + lines[-keep:]
        self.lines += ["$ " + command, *lines, ""]

    def say(self, text):
        self.lines += ["# " + text, ""]

    def write(self, path):
        text = "\n".join(self.lines).rstrip() + "\n"
        with open(path + ".new", "w") as file:
            file.write(text.replace(self.folder + "/", ""))
        os.replace(path + ".new", path)


class Slurm(unittest.TestCase):
    def setUp(self):
        missing = slurm_cluster.missing()
        if not missing and os.geteuid() != 0:
            missing = ["root, who alone may start slurmd"]
        if missing:
            text = "NO SLURM, NOT TESTED: lacks " + ", ".join(missing)
            if os.environ.get("FASCICLE_REQUIRE_SLURM") == "1":
                self.fail(text)
            print(text, file=sys.stderr)
            self.skipTest(text)

    def begin(self, seconds_of_a_bake):
        """Makes a new folder, and a Slurm in it."""
        self.seconds_of_a_bake = seconds_of_a_bake
        self.folder = tempfile.mkdtemp(prefix="fascicle-slurm-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        # A name that scripts must quote.
        self.home = os.path.join(self.folder, "a farm's $HOME, 50%a")
        os.mkdir(self.home)
        os.environ["FASCICLE_CACHE_DIR"] = os.path.join(self.folder, "cache")
        # Twice as many parallel tasks as most CI machines have cores: they are small.
        self.cluster = slurm_cluster.Cluster(os.path.join(self.folder, "slurm"), cpus=4)
        self.addCleanup(self.cluster.stop)
        self.cluster.start()
        self.transcript = Transcript(self.home)

    def in_time(self, test):
        for seconds in SECONDS_OF_A_BAKE:
            try:
                self.begin(seconds)
                return test()
            except slurm_cluster.TooLate as error:
                print("bakes of %.1f s: %s" % (seconds, error), file=sys.stderr)
                self.cluster.cancel_all()
                self.cluster.stop()
        self.fail("not even bakes of %.1f s could be caught at work" % SECONDS_OF_A_BAKE[-1])

    def write_list(self):
        """Writes jobs of about seconds_of_a_bake each. The short form has variations of a bar, which builds at once;
        the long one variations of a character's clips, each of which builds a body."""
        self.list = os.path.join(self.home, "jobs.toml")
        text = 'output = "bakes"\nformat = ["pc2"]\n\n'
        if IS_LONG:
            values = ", ".join(str(40000 + 1000 * k) for k in range(JOBS // 2))
            text += ('[job.bear]\nscene = "crouch"\nclips = "all"\n'
                     'set = ["scene.end=0.5", "motion.hold=0.0", "character.resolution=0.12"]\n\n'
                     '[job.bear.vary]\n"layers.fat.youngs_modulus" = [%s]\n' % values)
        else:
            values = ", ".join("%.3f" % (0.3 + 0.5 * k / JOBS) for k in range(JOBS))
            text += ('[job.bar]\nscene = "bar-hang-none"\nset = ["scene.end=%.1f"]\n\n'
                     '[job.bar.vary]\n"layers.body.alpha" = [%s]\n' % (8.0 * self.pace(), values))
        with open(self.list, "w") as file:
            file.write(text)

    def pace(self):
        """How many times a bake of 8 s of the scene fits into seconds_of_a_bake, by the faster of two runs: the first
        reads the program from disk, and bakes must be long enough to be caught while running."""
        seconds = []
        for name in ("first", "second"):
            begin = time.monotonic()
            done = fascicle("bake", "bar-hang-none", "--end", "8", "--threads", "1", "--device", "cpu", "-o",
                            os.path.join(self.folder, name))
            self.assertEqual(done.returncode, 0, done.stderr)
            seconds.append(time.monotonic() - begin)
        return self.seconds_of_a_bake / min(seconds)

    def bake_plainly(self):
        self.plain = os.path.join(self.folder, "plain")
        done = fascicle("batch", self.list, "-o", self.plain, cwd=self.home)
        self.assertEqual(done.returncode, 0, done.stderr)

    def files(self, folder):
        """{relative path: bytes} of all bakes."""
        found = {}
        for parent, folders, names in os.walk(folder):
            folders[:] = [name for name in folders if not name.startswith(".")]
            for name in names:
                path = os.path.join(parent, name)
                if name in OF_ITS_RUN or os.path.dirname(path) == folder:
                    continue
                with open(path, "rb") as file:
                    found[os.path.relpath(path, folder)] = file.read()
        return found

    def rows(self, folder):
        with open(os.path.join(folder, "batch.json")) as file:
            return {row["job"]: row for row in json.load(file)["jobs"]}

    def rows_of_bakes(self):
        return self.rows(os.path.join(self.home, "bakes"))

    def emit(self, *more):
        command = ["batch", "jobs.toml", "--emit", "slurm", "-o", "job", "--threads", "1", "--at-once", "3", "--submit",
                   *more]
        done = fascicle(*command, cwd=self.home, env=self.cluster.environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.transcript.add("fascicle " + " ".join(command), done.stdout)
        with open(os.path.join(self.home, "job", "submitted")) as file:
            ids = dict(line.split() for line in file)
        return ids["array"], ids["merge"]

    def status(self, of="job"):
        return fascicle("batch", "status", of, cwd=self.home)

    def running(self, array):
        return [name for name, state in self.cluster.tasks().items()
                if name.startswith(array + "_") and state == "RUNNING"]

    def wait_for_running(self, array, count=1):
        self.cluster.wait_for(lambda: len(self.running(array)) >= count, 30, "%d tasks to run" % count)
        return self.running(array)

    def bakes_at_work(self):
        """{job: PID of `batch --job`} of running bakes that have written a manifest."""
        found = {}
        folder = os.path.join(self.home, "bakes", ".outcomes")
        for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
            if not name.endswith(".json"):
                continue
            with open(os.path.join(folder, name)) as file:
                record = json.load(file)
            job = name[:-len(".json")]
            if record["exit_status"] is None and os.path.exists(
                    os.path.join(self.home, "bakes", job, "manifest.json")) and os.path.exists(
                        "/proc/%d" % record["process"]):
                found[job] = record["process"]
        return found

    def wait_for_end(self, merge, seconds=60 + 20 * JOBS):
        def has_ended():
            self.cluster.hurry()
            return self.cluster.tasks().get(merge) in ("COMPLETED", "FAILED")
        self.cluster.wait_for(has_ended, seconds, "the merge to end")
        return self.cluster.tasks()[merge]

    def jobs_of_tasks(self):
        with open(os.path.join(self.home, "job", "tasks")) as file:
            return [line.split(",") for line in file.read().split()]

    def task_at_work(self, array, other_than=()):
        """A task whose bake has begun: (name, PID of `batch --job`)."""
        tasks = self.jobs_of_tasks()
        found = []

        def choose():
            running = self.running(array)
            for job, process in self.bakes_at_work().items():
                number = 1 + next(k for k, jobs in enumerate(tasks) if job in jobs)
                task = "%s_%d" % (array, number)
                if task in running and task not in other_than:
                    found.append((task, process))
            return found
        self.cluster.wait_for(choose, 60, "a task to be at work")
        return found[0]

    def kill_bake(self, array, other_than=()):
        """Sends SIGKILL to a task's program and its bake, as when memory runs out; returns the task's jobs."""
        task, process = self.task_at_work(array, other_than)
        try:
            with open("/proc/%d/task/%d/children" % (process, process)) as file:
                children = [int(word) for word in file.read().split()]
            for one in [process, *children]:
                os.kill(one, signal.SIGKILL)
        except (FileNotFoundError, ProcessLookupError):
            raise slurm_cluster.TooLate("task %s was over before it was killed" % task)
        return self.jobs_of_tasks()[int(task.rpartition("_")[2]) - 1]

    def restarts(self, task):
        text = self.cluster.say("scontrol", "show", "job", "--oneliner", task)
        return int(text.partition(" Restarts=")[2].split()[0])

    def warn(self, array):
        """Sends what Slurm sends before a task's time limit, only to its shell; returns the task."""
        task, process = self.task_at_work(array)
        before = self.restarts(task)
        try:
            with open("/proc/%d/stat" % process) as file:
                shell = int(file.read().rpartition(")")[2].split()[1])
            os.kill(shell, signal.SIGTERM)
        except (FileNotFoundError, ProcessLookupError):
            raise slurm_cluster.TooLate("task %s was over before it was warned" % task)
        self.cluster.wait_for(lambda: self.restarts(task) > before, 30, "task %s to be queued again" % task)
        return task

    def test_every_bake_is_that_of_an_unbroken_batch(self):
        self.in_time(self.hold_a_disturbed_batch)

    def hold_a_disturbed_batch(self):
        cluster, transcript = self.cluster, self.transcript
        self.write_list()
        self.bake_plainly()
        with open(self.list) as file:
            transcript.add("cat jobs.toml", file.read())

        array, merge = self.emit("--slurm", "--partition=bakes")
        transcript.add("fascicle batch status job", self.status().stdout, keep=4)

        warned = self.warn(array)
        transcript.say("task %s gets the signal that comes before its time limit" % warned)
        requeued = self.task_at_work(array, other_than=[warned])[0]
        cluster.say("scontrol", "requeue", requeued)
        transcript.say("scontrol requeue " + requeued)
        killed = set(self.kill_bake(array, other_than=[warned, requeued]))
        transcript.say("the task of %s is killed" % " and ".join(sorted(killed)))

        self.wait_for_running(array)
        urgent = cluster.say("sbatch", "--parsable", "--partition=urgent", "--exclusive", "--output=/dev/null",
                             "--wrap=sleep 0.5").strip()
        cluster.wait_for(lambda: cluster.tasks().get(urgent) == "COMPLETED", 30, "the urgent job to end")
        transcript.say("an urgent job takes the whole node, and gives it back")

        cluster.say("scontrol", "update", "NodeName=farm", "State=DRAIN", "Reason=test")
        cluster.wait_for(lambda: "drain" in cluster.say("sinfo", "--noheader", "--format=%T"), 10,
                         "the node to be drained")
        cluster.say("scontrol", "update", "NodeName=farm", "State=RESUME")
        cluster.restart()
        transcript.say("the node is drained and resumed, Slurm's daemons are restarted")

        half = self.status()
        transcript.add("fascicle batch status job", half.stdout, keep=4)
        if IS_LONG:
            for _ in range(3):
                cluster.say("scontrol", "requeue", self.task_at_work(array)[0])
                warned = self.warn(array)
                killed.update(self.kill_bake(array, other_than=[warned]))
            transcript.say("three more tasks are requeued, three are warned, three are killed")

        ended = self.wait_for_end(merge)
        if ended == "COMPLETED" and all(row["status"] == "done" for row in self.rows_of_bakes().values()):
            # The kill came after everything was written, which cannot be known in advance; the result must be right all
            # the same.
            self.hold_all()
            raise slurm_cluster.TooLate("the bakes of %s were over before they were killed" % " and ".join(killed))
        self.assertEqual(ended, "FAILED", "a bake was killed, and the merge did not say so")
        self.hold_what_was_done(killed)
        with open(os.path.join(self.home, "job", "report.txt")) as file:
            transcript.add("cat job/report.txt", file.read(), keep=4)

        array, merge = self.emit("--resume")
        self.assertEqual(self.wait_for_end(merge), "COMPLETED", self.logs())
        self.hold_all()
        final = self.status("bakes")
        self.assertEqual(final.returncode, 0, final.stdout)
        self.assertIn("%d jobs in bakes: %d done\n" % (JOBS, JOBS), final.stdout)
        transcript.add("fascicle batch status bakes", final.stdout, keep=4)
        if TRANSCRIPT:
            transcript.say("all files of all %d bakes have the bytes of `fascicle batch` unbroken" % JOBS)
            transcript.write(TRANSCRIPT)

    @unittest.skipUnless(IS_LONG, "Slurm's shortest time limit is a minute: ./do farm")
    def test_a_bake_outlasts_its_time_limit(self):
        """One bake, warned by Slurm itself 50 s before the end of each minute that it is given."""
        self.begin(SECONDS_OF_A_BAKE[0])
        self.list = os.path.join(self.home, "jobs.toml")
        with open(self.list, "w") as file:
            file.write('output = "bakes"\n[job.bar]\nscene = "bar-hang-none"\nset = ["scene.end=%.1f"]\n'
                       % (8.0 * self.pace() * 45.0 / self.seconds_of_a_bake))
        self.bake_plainly()
        array, merge = self.emit("--slurm", "--time=1 --signal=B:TERM@50")
        self.assertEqual(self.wait_for_end(merge, 600), "COMPLETED", self.logs())
        self.assertGreater(self.restarts(array + "_1"), 0, "it was over before it was warned")
        self.hold_all()

    def logs(self):
        text = ""
        folder = os.path.join(self.home, "job", "log")
        for name in sorted(os.listdir(folder)):
            with open(os.path.join(folder, name)) as file:
                text += "\n--- %s\n%s" % (name, file.read())
        return text

    def hold_what_was_done(self, killed):
        rows, plain = self.rows_of_bakes(), self.rows(self.plain)
        self.assertEqual(rows.keys(), plain.keys())
        for job, row in rows.items():
            if row["status"] == "done":
                self.assertEqual(row["last_position_hash"], plain[job]["last_position_hash"], job)
            else:
                self.assertIn(job, killed, row["error"] + self.logs())
                self.assertIn(row["status"], ("failed", "cut off", "not begun"), job)

    def hold_all(self):
        rows, plain = self.rows_of_bakes(), self.rows(self.plain)
        for job, row in plain.items():
            self.assertEqual(rows[job]["status"], "done", job)
            self.assertEqual(rows[job]["last_position_hash"], row["last_position_hash"], job)
        found, wanted = self.files(os.path.join(self.home, "bakes")), self.files(self.plain)
        self.assertGreater(len(wanted), 2 * len(plain))
        self.assertEqual(found.keys(), wanted.keys())
        for path, content in wanted.items():
            self.assertTrue(found[path] == content, path + ": has other bytes")


if __name__ == "__main__":
    unittest.main()
