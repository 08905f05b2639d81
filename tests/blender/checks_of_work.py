"""Checks of in_blender.py: a bake under way, cancelled, interfered with, refused or failing."""

import glob
import json
import os
import time

import bpy

from opened_character import baked_folder, flesh_of, open_character


def cancel(path, said):
    """Cancels a long bake midway, as the Cancel button does, after a short bake has finished."""
    from fascicle import operators
    armature = open_character(path, said)
    assert bpy.ops.fascicle.bake() == {"FINISHED"}
    folder = baked_folder(said)
    kept = {name: open(os.path.join(folder, name), "rb").read() for name in ("surface.pc2", "manifest.json")}
    kept_files = sorted(os.listdir(said["folder"]))
    objects = sorted(obj.name for obj in bpy.data.objects)
    # Long enough not to finish before it is cancelled.
    bpy.context.scene.frame_end = bpy.context.scene.frame_start + 2000
    armature.fascicle.quality = "final"
    work = operators.Work(bpy.context, armature)
    seen = 0
    while seen == 0:
        assert not work.step()
        seen = work.bake.done
        time.sleep(0.02)
    process = work.bake._process
    bpy.ops.fascicle.cancel()
    return {"seen": seen, "ended": process.poll() is not None,
            "left": sorted(os.listdir(said["folder"])), "kept_files": kept_files,
            "kept": all(open(os.path.join(folder, name), "rb").read() == data for name, data in kept.items()),
            "objects_kept": objects == sorted(obj.name for obj in bpy.data.objects),
            "running": len(operators._running), "can_bake_again": bpy.ops.fascicle.bake.poll()}


def other_memory(path, said):
    """Loads the file again while the program works on the first of two actions, so that all that Blender has lies
    elsewhere and old references are void, as after an undo. Changes a setting; then again, and removes the mesh."""
    from fascicle import operators
    armature = open_character(path, said)
    other = armature.animation_data.action.copy()
    other.name = "second"
    armature.fascicle.uses_list = True
    for action in (armature.animation_data.action, other):
        armature.fascicle.actions.add().action = action
    name, mesh_name = armature.name, next(obj.name for obj in bpy.data.objects if obj.type == "MESH")
    saved = os.path.join(os.path.dirname(said["folder"]), "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=saved)
    result = {"layers": []}
    for what in ("loaded", "removed"):
        work = operators.Work(bpy.context, bpy.data.objects[name])
        bpy.ops.wm.open_mainfile(filepath=saved)
        bpy.data.objects[name].fascicle.softness = 5.0
        if what == "removed":
            bpy.data.objects.remove(bpy.data.objects[mesh_name])
        try:
            while not work.step(waits=True):
                pass
            result[what] = [work.done, len(flesh_of(bpy.data.objects[name]))]
            for manifest in glob.glob(said["folder"] + "/*/manifest.json"):
                with open(manifest) as file:
                    result["layers"].append(json.load(file)["scene"]["layers"])
        except operators.Problem as problem:
            result[what] = str(problem)
    result.update(mesh=mesh_name, running=len(operators._running))
    return result


def undo_in_window(path, said):
    """Undoes a change while the program works. Yields as in_window does."""
    bpy.context.preferences.view.show_splash = False
    name = open_character(path, said).name
    press(bpy.ops.ed.undo_push, "EXEC_DEFAULT", message="Opened")
    bpy.data.objects[name].location.x = 1.0
    press(bpy.ops.ed.undo_push, "EXEC_DEFAULT", message="Moved")
    state = bpy.context.window_manager.fascicle
    press(bpy.ops.fascicle.bake)
    while state.progress == 0.0 and state.is_running:
        yield 0.02
    result = {"while_at_work": state.is_running}
    press(bpy.ops.ed.undo, "EXEC_DEFAULT")
    result["undone"] = bpy.data.objects[name].location.x == 0.0
    while state.is_running:
        yield 0.05
    result.update(flesh=len(flesh_of(bpy.data.objects[name])))
    yield result


def press(what, how="INVOKE_DEFAULT", **properties):
    """Presses a button."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    with bpy.context.temp_override(window=window, area=area):
        return what(how, **properties)


def in_window(path, said):
    """The button in a window, with Blender's timer running while the program works: one bake to the end, one cancelled.
    Yields seconds to wait, and finally the result."""
    bpy.context.preferences.view.show_splash = False
    armature = open_character(path, said)
    state = bpy.context.window_manager.fascicle
    result = {"pressed": sorted(press(bpy.ops.fascicle.bake)), "while_at_work": state.is_running}
    shares = []
    while state.is_running:
        shares.append(state.progress)
        yield 0.05
    result.update(shares=shares, flesh=len(flesh_of(armature)), files=sorted(os.listdir(said["folder"])))
    bpy.context.scene.frame_end = bpy.context.scene.frame_start + 2000
    press(bpy.ops.fascicle.bake)
    while state.progress == 0.0:
        yield 0.05
    result["ticks"] = len(shares)
    press(bpy.ops.fascicle.cancel)
    yield 0.5
    result.update(cancelled=not state.is_running, files_after=sorted(os.listdir(said["folder"])),
                  flesh_after=len(flesh_of(armature)))
    yield result


def refused(path, said):
    """The message for each problem, and that nothing is left behind."""
    armature = open_character(path, said)
    preferences = bpy.context.preferences.addons["fascicle"].preferences
    result = {}

    def said_by_bake(what):
        try:
            bpy.ops.fascicle.bake()
            result[what] = "finished"
        except RuntimeError as error:
            result[what] = str(error).strip()

    was = preferences.program
    preferences.program = "/nowhere/fascicle"
    said_by_bake("wrong path")
    preferences.program = ""
    path_before, os.environ["PATH"] = os.environ["PATH"], "/nowhere"
    said_by_bake("not on the path")
    os.environ["PATH"] = path_before
    preferences.program = was
    settings = armature.fascicle
    settings.only_bone = "no such bone"
    said_by_bake("a bone that is not there")
    settings.only_bone = ""
    settings.folder = "//fascicle"
    said_by_bake("not saved")
    settings.folder = said["folder"]
    settings.uses_list = True
    said_by_bake("an empty list")
    action = armature.animation_data.action
    twin = action.copy()
    action.name, twin.name = "Walk 1", "Walk_1"
    for entry in (action, twin):
        settings.actions.add().action = entry
    said_by_bake("two actions of one folder")
    settings.uses_list = False
    earlier = bpy.data.collections.new("Flesh Walk_1")
    earlier["fascicle_armature"], earlier["fascicle_bake"] = armature, twin.name
    said_by_bake("the folder of another action's bake")
    bpy.data.collections.remove(earlier)
    mesh = next(obj for obj in bpy.data.objects if obj.type == "MESH")
    mirror = mesh.modifiers.new("Mirror", "MIRROR")
    with bpy.context.temp_override(object=mesh):
        bpy.ops.object.modifier_move_to_index(modifier="Mirror", index=0)
    said_by_bake("a modifier before the armature's")
    mesh.modifiers.remove(mirror)
    armature.data.pose_position = "REST"
    said_by_bake("rest position")
    armature.data.pose_position = "POSE"
    armature.animation_data.action.name = "plain"
    occupied = os.path.join(said["folder"], armature.name + "-plain")
    os.makedirs(occupied)
    with open(os.path.join(occupied, "mine.txt"), "w") as file:
        file.write("mine")
    said_by_bake("a folder that is no bake")
    result["theirs"] = os.listdir(occupied)
    result["left"] = sorted(os.listdir(said["folder"]))
    result["flesh"] = [obj.name for obj in bpy.data.objects if obj.get("fascicle_mesh")]
    return result


def trouble_later(path, said):
    """A list of two actions, of which the second scales a bone to 0; then an error of the add-on itself. What is said,
    and whether the next bake can begin."""
    from fascicle import attach, operators
    armature = open_character(path, said)
    settings = armature.fascicle
    settings.range, settings.uses_list = "ACTION", True
    plain = armature.animation_data.action
    zero = plain.copy()
    zero.name = "zero"
    for curve in [curve for curve in zero.fcurves if curve.data_path == 'pose.bones["%s"].scale' % said["bone"]]:
        zero.fcurves.remove(curve)
    for index in range(3):
        zero.fcurves.new('pose.bones["%s"].scale' % said["bone"], index=index).keyframe_points.insert(1.0, 0.0)
    for action in (plain, zero):
        settings.actions.add().action = action
    result = {}

    def bake(what):
        try:
            bpy.ops.fascicle.bake()
            result[what] = "finished"
        except RuntimeError as error:
            result[what] = str(error).strip()
        result["running"] = result.get("running", 0) + len(operators._running)
        operators.stop()

    bake("zero")
    whole_attach, attach.attach = attach.attach, None
    settings.actions.remove(1)
    bake("of the add-on")
    attach.attach = whole_attach
    bake("after")
    return result
