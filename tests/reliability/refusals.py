"""How a program ends that is given what no tool should write: in time, without a crash, and with one error of one
line that names something of the input and nothing of its own inside."""

import re
import resource
import subprocess

from bakes import hold

PATIENCE = 120  # s; a bake here takes less than one on a machine that is not busy
BAD_USAGE, NOT_FINITE = 2, 5
MEMORY = 8 << 30  # bytes; what asks for more has to say so
# What a line of an error must not be: what a library or the language says of itself.
OF_THE_INSIDE = re.compile(r"std::|vector::|_M_|basic_string|bad_alloc|terminate called|Assertion|json\.exception")


def ended(command, environment, folder):
    """Runs it, its memory bounded as a farm bounds it: (status, all that it says). A signal or no end is Broken."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=folder, timeout=PATIENCE,
                              errors="replace",
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY)))
    except subprocess.TimeoutExpired:
        hold(False, "it does not end: " + " ".join(command))
    hold(done.returncode >= 0, "signal %d: %s" % (-done.returncode, " ".join(command)))
    return done.returncode, done.stdout + done.stderr


def hold_refusal(status, text, allowed, names=()):
    """One error, of one line, that names something of the input, and nothing of the inside."""
    hold(status in allowed, "ended with %d: %s" % (status, text))
    errors = [line for line in text.splitlines() if line.startswith("fascicle: error: ")]
    hold(len(errors) == 1, "%d errors: %s" % (len(errors), text))
    hold(not OF_THE_INSIDE.search(errors[0]), "speaks of the inside: " + errors[0])
    hold(not names or any(name in errors[0] for name in names), "names none of %s: %s" % (", ".join(names), errors[0]))
