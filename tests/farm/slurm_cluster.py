"""A one-node Slurm in its own folder: munged, slurmctld and slurmd, started by hand, without accounting.

The programs are Debian's slurm-wlm and munge. Everything else is in the folder, and stop() ends what start() began.
"""

import os
import shutil
import signal
import socket
import subprocess
import time

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "scontrol", "squeue", "sinfo", "scancel")

# Two partitions on the one node: jobs in `urgent` preempt those in `bakes`, which are requeued.
CONF = """
ClusterName=fascicle
SlurmctldHost={host}
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CryptoType=crypto/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SlurmdParameters=config_overrides
MpiDefault=none
ReturnToService=2
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerType=sched/backfill
SchedulerParameters=sched_interval=1,bf_interval=1,sched_min_interval=0
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
JobCompType=jobcomp/none
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
JobRequeue=1
KillWait=5
InactiveLimit=0
MinJobAge=3600
MaxArraySize=1001
NodeName=farm NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[1]} CPUs={cpus} RealMemory=1000 State=UNKNOWN
PartitionName=bakes Nodes=farm Default=YES MaxTime=INFINITE State=UP PriorityTier=1 PreemptMode=REQUEUE
PartitionName=urgent Nodes=farm MaxTime=INFINITE State=UP PriorityTier=10 PreemptMode=OFF
"""


class TooLate(Exception):
    """An event that a test waited for did not happen in time: the machine is busy or slow. Says nothing about the
    result."""


def missing():
    """The missing programs."""
    paths = os.environ["PATH"] + ":/usr/sbin:/usr/local/sbin"
    return [name for name in PROGRAMS if shutil.which(name, path=paths) is None]


def free_ports(count):
    held = [socket.socket() for _ in range(count)]
    for one in held:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in held]
    for one in held:
        one.close()
    return ports


class Cluster:
    def __init__(self, folder, cpus):
        self.folder = folder
        self.environment = dict(os.environ, SLURM_CONF=os.path.join(folder, "slurm.conf"))
        self.environment["PATH"] += ":/usr/sbin:/usr/local/sbin"
        self.running = {}
        for name in ("state", "spool"):
            os.makedirs(os.path.join(folder, name))
        # munged refuses folders that others may write to.
        os.chmod(folder, 0o755)
        with open(self.environment["SLURM_CONF"], "w") as file:
            file.write(CONF.format(folder=folder, host=socket.gethostname(), ports=free_ports(2), cpus=cpus))
        key = os.path.join(folder, "munge.key")
        with open(key, "wb") as file:
            file.write(os.urandom(128))
        os.chmod(key, 0o600)

    def begin(self, name, *arguments):
        with open(os.path.join(self.folder, name + ".out"), "ab") as log:
            self.running[name] = subprocess.Popen(
                [name, *arguments], env=self.environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                start_new_session=True)

    def start(self):
        at = lambda name: os.path.join(self.folder, name)
        self.begin("munged", "--foreground", "--force", "--key-file=" + at("munge.key"), "--num-threads=2",
                   "--socket=" + at("munge.socket"), "--pid-file=" + at("munge.pid"),
                   "--log-file=" + at("munge.log"), "--seed-file=" + at("munge.seed"))
        self.wait_for(lambda: os.path.exists(at("munge.socket")), 60, "munged to start")
        self.start_controller()
        self.start_node()
        self.wait_for(lambda: "idle" in self.say("sinfo", "--noheader", "--format=%T"), 60, "the node to be idle")

    def start_controller(self):
        self.begin("slurmctld", "-D")
        self.wait_for(lambda: self.try_to("scontrol", "ping").stdout.count("UP"), 60, "slurmctld to answer")

    def start_node(self):
        self.begin("slurmd", "-D", "-N", "farm")

    def restart(self):
        """Restarts both daemons while tasks continue. slurmd must start last: it registers with a new controller when
        it starts."""
        self.end("slurmctld")
        self.end("slurmd")
        self.start_controller()
        self.start_node()

    def end(self, name, number=signal.SIGTERM):
        process = self.running.pop(name, None)
        if process is None:
            return
        process.send_signal(number)
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def cancel_all(self):
        """Cancels all jobs, also running ones, and waits until they are gone."""
        self.try_to("scancel", "--user=root")
        end = time.monotonic() + 20
        while time.monotonic() < end and self.try_to("squeue", "--noheader").stdout.strip():
            time.sleep(0.1)

    def stop(self):
        for name in ("slurmd", "slurmctld", "munged"):
            self.end(name)

    def try_to(self, *command):
        return subprocess.run(command, env=self.environment, capture_output=True, text=True)

    def say(self, *command):
        """Returns a command's output; raises if it fails."""
        done = self.try_to(*command)
        if done.returncode != 0:
            raise RuntimeError(" ".join(command) + ": " + done.stderr.strip())
        return done.stdout

    def tasks(self):
        """{"7_3": "RUNNING", ...}: one entry per array task, and one per job."""
        rows = {}
        for line in self.say("squeue", "--noheader", "--array", "--states=all", "--format=%i %T").splitlines():
            name, state = line.split()
            rows[name] = state
        return rows

    def hurry(self):
        """Slurm delays a requeued job by two minutes; this removes the delay."""
        for line in self.say("squeue", "--noheader", "--array", "--states=PENDING", "--format=%i %r").splitlines():
            name, reason = line.split(maxsplit=1)
            if reason == "BeginTime":
                self.try_to("scontrol", "update", "JobId=" + name, "StartTime=now")

    def wait_for(self, holds, seconds, what):
        end = time.monotonic() + seconds
        while not holds():
            if time.monotonic() > end:
                raise TooLate("waited %d s for %s" % (seconds, what))
            time.sleep(0.1)
