"""blender --background --factory-startup --python in_blender.py -- CHECK RESULT [ARGUMENT...]

Runs one check of the installed add-on inside Blender and writes what it found to RESULT as JSON, for addon_test.py to
judge. The checks are the functions of checks_of_*.py."""

import functools
import json
import os
import sys
import traceback

import bpy

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import checks_of_bakes
import checks_of_paint
import checks_of_work


def finish(target, found):
    with open(target, "w") as file:
        json.dump(found, file)


def tick(steps, target):
    """Runs a check that waits from Blender's timer, so that Blender's loop runs in between."""
    try:
        found = next(steps)
        if not isinstance(found, dict):
            return found
        finish(target, found)
        bpy.ops.wm.quit_blender()
    except BaseException:
        traceback.print_exc()
        os._exit(1)


arguments = sys.argv[sys.argv.index("--") + 1:]
check, target, character = arguments[:3]
checks = vars(checks_of_bakes) | vars(checks_of_work) | vars(checks_of_paint)
found = checks[check](character, dict(pair.split("=", 1) for pair in arguments[3:]))
if isinstance(found, dict):
    finish(target, found)
else:
    bpy.app.timers.register(functools.partial(tick, found, target), first_interval=0.5, persistent=True)
