"""Bakes under the Khronos validation layer, which the loader puts between the program and the driver."""

import os
import re
import shutil
import subprocess

from bakes import DONE, PROGRAM, hold, must_be_found

PATIENCE = 7200  # s; instrumented shaders take minutes on a busy software device
# Optional checks to enable in the layer, and the planted faults that it must then report.
PASSES = (
    ("synchronization", ("VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT",
                         "VALIDATION_CHECK_ENABLE_SYNCHRONIZATION_VALIDATION_QUEUE_SUBMIT"),
     (("core", "VUID-vkCmdCopyBuffer-size"), ("synchronization", "SYNC-HAZARD-WRITE-AFTER-WRITE"))),
    ("GPU-assisted", ("VK_VALIDATION_FEATURE_ENABLE_GPU_ASSISTED_EXT",),
     (("core", "VUID-vkCmdCopyBuffer-size"), ("gpu", "access out of bounds"))),
)
# Scenes that are long after their end, or quiet at their start: the frames to bake.
FRAMES = {"crouch": ["--start", "1.85", "--end", "1.884", "--hold", "0"]}


def under_layer(command, environment, folder, enables):
    """Runs a command under the layer: (completed process, the layer's log)."""
    log = os.path.join(folder, "layer.log")
    with open(os.path.join(folder, "vk_layer_settings.txt"), "w") as file:
        file.write("khronos_validation.debug_action = VK_DBG_LAYER_ACTION_LOG_MSG\n"
                   "khronos_validation.report_flags = error,warn,perf\n"
                   "khronos_validation.log_filename = %s\n"
                   "khronos_validation.enables = %s\n" % (log, ",".join(enables)))
    if os.path.exists(log):
        os.remove(log)
    with_layer = {**environment, "VK_LAYER_SETTINGS_PATH": folder, "VK_INSTANCE_LAYERS": "VK_LAYER_KHRONOS_validation"}
    done = subprocess.run(command, capture_output=True, text=True, env=with_layer, timeout=PATIENCE)
    # The layer creates its log when it is loaded.
    hold(os.path.exists(log), "the layer was not loaded (Debian: vulkan-validationlayers): " + done.stderr)
    with open(log, errors="replace") as file:
        return done, file.read()


def hold_silent(name, text):
    hold(not text.strip(), "%s: the layer says: %s" % (name, text[:2000]))


def layers(bakes, count):
    """Built-in scenes bake a few frames on a Vulkan device under the Khronos validation layer: once with
    synchronization validation, within and across submissions, and once with GPU-assisted validation, which checks what
    shaders access. Neither may report anything."""
    folder = bakes[0].empty_folder()
    faults = os.environ.get("FASCICLE_PLANTED_FAULTS", "")
    hold(os.path.exists(faults), "FASCICLE_PLANTED_FAULTS names no program")
    listed = subprocess.run([PROGRAM, "scenes"], capture_output=True, text=True, check=True).stdout
    scenes = re.findall(r"^  ([\w.-]+)  ", listed, re.MULTILINE)
    hold(len(scenes) > 10, "`scenes` lists hardly any: " + listed)
    # The smallest come first, for the short form.
    scenes.sort(key=lambda name: not name.startswith("bar-hang"))
    chosen = scenes[:count]
    for name, enables, planted in PASSES:
        environment = bakes[0].environment(FASCICLE_CACHE_DIR=os.path.join(folder, "cache"))
        for fault, said in planted:
            done, text = under_layer([faults, fault], environment, folder, enables)
            hold(done.returncode == DONE, "planted_faults %s: %s" % (fault, done.stderr))
            hold(said in text, "%s: the layer does not report the planted fault (%s): %s" % (name, fault, text))
            must_be_found(lambda: hold_silent(name, text), "a message from the layer")
        for scene in chosen:
            out = os.path.join(folder, "out")
            frames = FRAMES.get(scene, ["--end", "0.034"])
            command = [PROGRAM, "bake", scene, *frames, "--device", "vulkan", "--format", "none", "-o", out]
            done, text = under_layer(command, environment, folder, enables)
            hold(done.returncode == DONE, "%s, %s: %s" % (scene, name, done.stderr))
            hold_silent(scene + ", " + name, text)
            shutil.rmtree(out)
    shutil.rmtree(folder)
    return "%d of %d scenes: 0 messages from core, synchronization and GPU-assisted validation; each of the three " \
           "reports the fault that is planted for it" % (len(chosen), len(scenes))
