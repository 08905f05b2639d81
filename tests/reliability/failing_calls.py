"""Calls that change files fail, or end the program, as the preloaded library failing_calls.cpp is told to."""

import os

from bakes import DONE, hold


def library():
    path = os.environ.get("FASCICLE_FAILING_CALLS", "")
    hold(os.path.exists(path), "FASCICLE_FAILING_CALLS names no library")
    return path


def count_of(folder):
    return folder + ".calls"


def plan(folder, number, error, mode):
    """An environment in which call `number` below the folder, from 1, fails (`once`), it and all later ones do
    (`from`), or SIGKILL ends the program before it (`kill`). 0: no call fails."""
    return {"LD_PRELOAD": library(), "FAILING_FOLDER": folder, "FAILING_CALL": str(number), "FAILING_MODE": mode,
            "FAILING_COUNT": count_of(folder), "FAILING_ERROR": str(error)}


def calls_in(folder):
    """The count that the library wrote. Each process writes one; this is the largest."""
    hold(os.path.exists(count_of(folder)), "no call was counted: the library is not preloaded or does not work")
    with open(count_of(folder)) as file:
        found = max(int(line) for line in file)
    os.remove(count_of(folder))
    return found


def counted_calls(run, folder):
    """The number of calls of run(**environment), which is not disturbed."""
    done = run(**plan(folder, 0, 0, "once"))
    hold(done.returncode == DONE, done.stderr)
    calls = calls_in(folder)
    hold(calls > 4, "%s: hardly any calls were counted" % folder)
    return calls
