"""A Vulkan device that fails: a layer between the loader and the driver returns an error from any call."""

import os
import random
import shutil

from bakes import DONE, frame_of_checkpoint, hold, hold_verified, manifest, must_be_found

NO_DEVICE, DEVICE_FAILED = 4, 7
RESULTS = ((-4, "VK_ERROR_DEVICE_LOST"), (-2, "VK_ERROR_OUT_OF_DEVICE_MEMORY"), (-1, "VK_ERROR_OUT_OF_HOST_MEMORY"),
           (-3, "VK_ERROR_INITIALIZATION_FAILED"), (2, "VK_TIMEOUT"))
SETTING_UP = 200  # calls, roughly
OPENING = 4  # calls that make the instance and look for devices


def with_layer(call, result, **more):
    """An environment in which this Vulkan call, counted from 1, returns this result. 0: no call fails."""
    folder = os.path.dirname(os.environ.get("FASCICLE_FAULT_LAYER", ""))
    hold(folder and os.path.isdir(folder), "FASCICLE_FAULT_LAYER names no layer's description")
    # Mesa's layer that sorts devices (22.3.6) crashes if one of its own queries fails.
    return {"VK_INSTANCE_LAYERS": "VK_LAYER_FASCICLE_faults", "VK_LAYER_PATH": folder, "NODEVICE_SELECT": "1",
            "FASCICLE_FAULT": "%d %d" % (call, result), **more}


def calls_of(bake):
    """The number of calls in a whole bake that can fail. Also checks that the layer alone changes nothing."""
    folder, said = bake.empty_folder(), os.path.join(bake.root, "calls")
    done = bake.run(folder, "--device", "vulkan:0", **with_layer(0, 0, FASCICLE_FAULT_COUNT=said))
    hold(done.returncode == DONE, "under a layer that fails no call: " + done.stderr)
    bake.hold_whole(folder)
    shutil.rmtree(folder)
    with open(said) as file:
        calls = int(file.read())
    hold(calls > 60, "%d calls: the layer is not loaded" % calls)
    return calls


def hold_handed_over(bake, folder, done, name):
    """The CPU finished the bake with the same bytes, and a message gave the reason. False if the bake stayed on the
    device: some calls, such as the one for kept pipelines, may fail without harm."""
    hold(done.returncode == DONE, "%s: after %s it exited with %d: %s" % (folder, name, done.returncode, done.stderr))
    bake.hold_whole(folder)
    to_cpu = manifest(folder)["device"]["solver"] == "cpu"
    hold(to_cpu == (name in done.stderr), "%s: on the CPU: %s; the reason is %s, but the message is: %s"
         % (folder, to_cpu, name, done.stderr))
    return to_cpu


def hold_checkpoint(bake, folder):
    """Once there are frames, a resumed bake does not start over."""
    frames = bake.frames_in(folder)
    hold(frames == 0 or frame_of_checkpoint(folder) is not None,
         "%s: there are %d frames, but no checkpoint" % (folder, frames))


def hold_kept(bake, folder, done, name):
    """The frames so far are kept, and a resumed bake continues from them on the CPU. False if the failed call did no
    harm."""
    if done.returncode == DONE:
        bake.hold_whole(folder)
        return False
    hold(done.returncode in (NO_DEVICE, DEVICE_FAILED) and name in done.stderr,
         "%s: after %s it exited with %d: %s" % (folder, name, done.returncode, done.stderr))
    hold_checkpoint(bake, folder)
    if done.returncode == DEVICE_FAILED:
        hold("--resume" in done.stderr, "%s: the message does not mention --resume: %s" % (folder, done.stderr))
    said = manifest(folder)
    if said is not None:
        hold(said["status"] == "failed" and name in said["message"],
             "%s: the manifest says: %s" % (folder, said["status"]))
        hold_verified(folder)
    bake.resume(folder)
    return True


def device_faults(bakes, count):
    """A Vulkan layer of our own lets the k-th call return DEVICE_LOST, OUT_OF_DEVICE_MEMORY, OUT_OF_HOST_MEMORY,
    INITIALIZATION_FAILED or TIMEOUT. A bake that may continue on the CPU (`--device vulkan:0,cpu`) does so. One that
    may not keeps its checkpoint, says what failed, and `--resume` completes it."""
    seldom = 20  # the character's bake takes ten times as long
    chosen = bakes[:2] if count >= seldom else bakes[:1]
    calls = [calls_of(bake) for bake in chosen]
    folder = chosen[0].empty_folder()
    done = chosen[0].run(folder, "--device", "vulkan:0,cpu", **with_layer(1, -3))
    must_be_found(lambda: hold_handed_over(chosen[0], folder, done, "VK_TIMEOUT"), "the wrong reason")
    must_be_found(lambda: hold_kept(chosen[0], folder, chosen[0].run(folder), "VK_TIMEOUT"),
                  "no failure")
    os.remove(os.path.join(folder, "checkpoint"))
    must_be_found(lambda: hold_checkpoint(chosen[0], folder), "frames without a checkpoint")
    shutil.rmtree(folder)
    handed_over = kept = harmless = 0
    for k in range(count):
        which = 1 if k % seldom == seldom - 1 else 0
        bake = chosen[which]
        # Every other call is one of those that set up the device, and some of these come before there is one.
        call = random.randint(1, calls[which] - 1 if k % 2 else SETTING_UP if k % 10 else OPENING)
        result, name = RESULTS[k // 2 % len(RESULTS)]
        folder = bake.empty_folder()
        environment = with_layer(call, result)
        alone = k // 4 % 2 == 1
        done = bake.run(folder, "--device", "vulkan:0" if alone else "vulkan:0,cpu", **environment)
        if alone and hold_kept(bake, folder, done, name):
            kept += 1
        elif not alone and hold_handed_over(bake, folder, done, name):
            handed_over += 1
        else:
            harmless += 1
        shutil.rmtree(folder)
    return "%d runs, each with one of %d to %d calls failing: the CPU took over %d times, --resume completed the " \
           "bake %d times, the device did without the call %d times; all bytes equal" % (
               count, min(calls), max(calls), handed_over, kept, harmless)
