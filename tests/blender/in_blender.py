"""blender --background --factory-startup --python in_blender.py -- CHECK RESULT [ARGUMENT...]

Runs one check of the installed add-on inside Blender and writes what it found to RESULT as JSON, for addon_test.py to
judge. Bakes are decoded here, not by the add-on's reader."""

import functools
import glob
import hashlib
import json
import os
import re
import struct
import sys
import time
import traceback

import bmesh
import bpy
from mathutils import Euler, Matrix


def samples_of(path):
    with open(path, "rb") as file:
        magic, version, points, start, step, count = struct.unpack("<12siiffi", file.read(32))
        assert magic == b"POINTCACHE2\0" and version == 1 and step == 1
        return [struct.unpack("<%df" % (3 * points), file.read(12 * points)) for _ in range(count)]


def evaluated(obj, world=False):
    """The current vertex positions, in the object's space or in the world."""
    found = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = found.to_mesh()
    places = [found.matrix_world @ vertex.co if world else vertex.co.copy() for vertex in mesh.vertices]
    found.to_mesh_clear()
    return places


def in_files_axes(place):
    return place.x, place.z, -place.y


def flesh_of(armature):
    return sorted((obj for obj in bpy.data.objects if obj.get("fascicle_mesh") and not obj.hide_get()
                   and not obj.users_collection[0].hide_viewport), key=lambda obj: obj["fascicle_mesh"].name)


def options(argv):
    return dict(pair.split("=", 1) for pair in argv)


def frames_of(said):
    return int(said.get("first", 1)), int(said.get("last", 7))


def open_character(path, said):
    """Imports a character and makes its armature active; placed and scaled as `said` asks."""
    if bpy.app.background:
        bpy.ops.wm.read_factory_settings(use_empty=True)
    for obj in list(bpy.data.objects):  # reloading the file would invalidate the window's context
        bpy.data.objects.remove(obj)
    bpy.ops.preferences.addon_enable(module="fascicle")
    scene = bpy.context.scene
    scene.render.fps = int(said.get("fps", 24))
    # Debian's numpy is too new for the importer's default shading.
    bpy.ops.import_scene.gltf(filepath=path, import_shading="SMOOTH")
    for obj in [obj for obj in bpy.data.objects if obj.type == "MESH" and obj.name.startswith("Icosphere")]:
        bpy.data.objects.remove(obj)  # the importer's bone shape
    armature = next(obj for obj in bpy.data.objects if obj.type == "ARMATURE")
    top = armature
    while top.parent:
        top = top.parent
    if "moved" in said:
        top.rotation_mode = "XYZ"
        top.matrix_world = (Matrix.Translation((0.7, -1.3, 0.4)) @ Euler((0.3, -0.2, 1.1)).to_matrix().to_4x4()
                            @ Matrix.Scale(1.25, 4) @ top.matrix_world)
    unit = float(said.get("unit", 1.0))
    if unit != 1.0:
        scene.unit_settings.system = "METRIC"
        scene.unit_settings.scale_length = unit
        top.matrix_world = Matrix.Scale(1.0 / unit, 4) @ top.matrix_world
    bpy.context.view_layer.objects.active = armature
    settings = armature.fascicle
    settings.folder = said["folder"]
    settings.quality = "draft"
    first, last = frames_of(said)
    # The scene's range cannot begin below 0.
    settings.range = "SCENE" if first >= 0 else "ACTION"
    scene.frame_start, scene.frame_end = max(first, 0), last
    action = armature.animation_data.action
    action.use_frame_range = True
    action.frame_start, action.frame_end = first, last
    return armature


def baked_folder(said):
    folders = [found for found in glob.glob(said["folder"] + "/*") if os.path.isdir(found)]
    assert len(folders) == 1, folders
    return folders[0]


def measure_exact(armature, folder, first):
    """The largest difference between a vertex's floats and the bake's, over all frames, with objects in order."""
    scene = bpy.context.scene
    samples = samples_of(os.path.join(folder, "surface.pc2"))
    largest = 0.0
    for number, sample in enumerate(samples):
        scene.frame_set(first + number)
        found = [x for obj in flesh_of(armature) for place in evaluated(obj) for x in in_files_axes(place)]
        assert len(found) == len(sample), (len(found), len(sample))
        largest = max(largest, max(abs(a - b) for a, b in zip(found, sample)))
    return largest, len(samples)


def round_trip(path, said):
    armature = open_character(path, said)
    settings = armature.fascicle
    settings.attachment = said.get("kind", "MESH_CACHE")
    settings.only_bone = said.get("only", "")
    before = {obj.name: [slot.material.name for slot in obj.material_slots if slot.material] for obj in bpy.data.objects
              if obj.type == "MESH"}
    for obj in bpy.data.objects:
        if obj.type == "MESH":
            obj.modifiers.new("Later", "SUBSURF").show_viewport = False
    bpy.context.scene.frame_set(3)
    assert bpy.ops.fascicle.bake() == {"FINISHED"}
    result = {"frame": bpy.context.scene.frame_current, "folder": baked_folder(said)}
    result["error"], result["frames"] = measure_exact(armature, result["folder"], frames_of(said)[0])
    flesh = flesh_of(armature)
    result["materials_kept"] = all([slot.material.name for slot in obj.material_slots if slot.material]
                                   == before[obj["fascicle_mesh"].name] for obj in flesh)
    result["materials"] = sum(len(names) for names in before.values())
    result["objects"] = len(flesh)
    result["modifiers"] = [modifier.type for obj in flesh for modifier in obj.modifiers]
    first, last = frames_of(said)
    # The skinned positions: with `only`, most of the body just follows the skeleton.
    scene = bpy.context.scene
    meshes = [obj["fascicle_mesh"] for obj in flesh]
    result["hidden"] = all(obj.hide_viewport and obj.hide_render for obj in meshes)
    with_flesh, skinned = [], []
    for places, name in ((with_flesh, flesh[0].users_collection[0]["fascicle_bake"]), (skinned, "")):
        bpy.ops.fascicle.show(bake=name)
        for frame in range(first, last + 1):
            scene.frame_set(frame)
            places.append([place for obj in (flesh if name else meshes) for place in evaluated(obj, world=True)])
    size = max(max(place[axis] for place in skinned[0]) - min(place[axis] for place in skinned[0]) for axis in range(3))
    apart = sorted((a - b).length / size for now, there in zip(with_flesh, skinned) for a, b in zip(now, there))
    moved = max((a - b).length / size for now in skinned for a, b in zip(now, skinned[0]))
    result.update(median=apart[len(apart) // 2], largest=apart[-1], moved=moved)
    # Clear removes the flesh and nothing else.
    bpy.context.view_layer.objects.active = armature
    bpy.ops.fascicle.clear()
    result["left"] = [obj.name for obj in bpy.data.objects if obj.get("fascicle_mesh")]
    result["collections_left"] = [found.name for found in bpy.data.collections if found.name.startswith("Flesh")]
    result["shown"] = all(not obj.hide_viewport and not obj.hide_render for obj in meshes)
    return result


def list_of_actions(path, said):
    """Bakes the character's action and a copy of half the length."""
    armature = open_character(path, said)
    settings = armature.fascicle
    settings.range = "ACTION"
    first = armature.animation_data.action
    other = first.copy()
    other.name = "second"
    # Both are shortened; the point is that each has its own range.
    settings.uses_list = True
    for action, last in ((first, 8.0), (other, 5.0)):
        action.use_frame_range = True
        action.frame_start, action.frame_end = 2.0, last
        settings.actions.add().action = action
    assert bpy.ops.fascicle.bake() == {"FINISHED"}
    result = {"open": armature.animation_data.action.name, "first": first.name, "bakes": {}}
    for folder in sorted(found for found in glob.glob(said["folder"] + "/*") if os.path.isdir(found)):
        result["bakes"][os.path.basename(folder)] = len(samples_of(os.path.join(folder, "surface.pc2")))
    result["shown"] = [found["fascicle_bake"] for found in bpy.data.collections
                       if found.get("fascicle_bake") and not found.hide_viewport]
    bpy.ops.fascicle.show(bake="second")
    result["open_after_show"] = armature.animation_data.action.name
    result["shown_after_show"] = [found["fascicle_bake"] for found in bpy.data.collections
                                  if found.get("fascicle_bake") and not found.hide_viewport]
    return result


def pose_between_actions(path, said):
    """Bakes a list of actions, of which the first keys what the second does not, over a pose that is not keyed. What is
    written of the second is the same as without the first, and the pose is as before."""
    armature = open_character(path, said)
    settings = armature.fascicle
    settings.range, settings.uses_list = "ACTION", True
    bone = armature.pose.bones[said["bone"]]
    bone.rotation_mode = "QUATERNION"
    bone["switch"] = 1.0
    armature.animation_data.action = None
    actions = {}
    for name, paths in (("bends", ["pose.bones[%r].rotation_quaternion", "pose.bones[%r]['switch']", "location"]),
                        ("rests", ["pose.bones[%r].location"])):
        actions[name] = action = bpy.data.actions.new(name)
        for path in paths:
            path = path % bone.name if "%" in path else path
            is_rotation = path.endswith("quaternion")
            for index in range(4 if is_rotation else 1):
                curve = action.fcurves.new(path.replace("'", '"'), index=index)
                for frame in (1.0, 2.0):
                    curve.keyframe_points.insert(frame, 1.0 if is_rotation and index == 0 else 0.05 * frame)

    def state():
        return [list(bone.rotation_quaternion), list(bone.location), bone["switch"], list(armature.location)]

    bone.rotation_quaternion = (0.8, 0.6, 0.0, 0.0)
    before = state()
    result = {"written": []}
    for names in (("rests",), ("bends", "rests")):
        settings.actions.clear()
        for name in names:
            settings.actions.add().action = actions[name]
        assert bpy.ops.fascicle.bake() == {"FINISHED"}
        # Their names are by their content.
        result["written"].append(sorted(glob.glob(said["folder"] + "/*-rests-*.glb")))
    result.update(before=before, after=state(), bakes=len(glob.glob(said["folder"] + "/*/surface.pc2")))
    return result


def cut_in_two(mesh, share):
    """A new mesh with this share of the faces, which the other one has no more."""
    other = mesh.copy()
    other.data = mesh.data.copy()
    mesh.users_collection[0].objects.link(other)
    count = int(len(mesh.data.polygons) * share)
    for obj, unwanted in ((mesh, slice(count)), (other, slice(count, None))):
        edited = bmesh.new()
        edited.from_mesh(obj.data)
        edited.faces.ensure_lookup_table()
        bmesh.ops.delete(edited, geom=edited.faces[unwanted], context="FACES")
        edited.to_mesh(obj.data)
        edited.free()
    return other


def again(path, said):
    """Cuts a character into two meshes and bakes it; puts files of the user in the folder and beside it; then bakes
    fewer frames."""
    armature = open_character(path, said)
    cut_in_two(next(obj for obj in bpy.data.objects if obj.type == "MESH"), 0.5)
    assert bpy.ops.fascicle.bake() == {"FINISHED"}
    folder = baked_folder(said)
    result = {"files": sorted(os.listdir(folder)), "beside": sorted(os.listdir(said["folder"])),
              "backup": os.path.basename(folder) + ".old"}
    own = [os.path.join(folder + ".old", "mine.txt"), os.path.join(folder, "render.png")]
    os.mkdir(folder + ".old")
    for name in own:
        with open(name, "w") as file:
            file.write("mine")
    bpy.context.scene.frame_end = 4
    assert bpy.ops.fascicle.bake() == {"FINISHED"}
    result.update(files_after=sorted(os.listdir(folder)), beside_after=sorted(os.listdir(said["folder"])),
                  mine=[open(name).read() for name in own], kept_backup=os.listdir(folder + ".old") == ["mine.txt"])
    result["error"], result["frames"] = measure_exact(armature, folder, frames_of(said)[0])
    return result


def moved_after_bake(path, said):
    """What a second bake writes of a character whose armature was moved after the first, is then keyed as an object,
    and is hidden; each beside what is written while the mesh is shown. A shape key is keyed too."""
    from fascicle import character
    armature = open_character(path, said)
    first, last = frames_of(said)
    mesh = next(obj for obj in bpy.data.objects if obj.type == "MESH")
    mesh.shape_key_add(name="Basis")
    key = mesh.shape_key_add(name="longer")
    for point in key.data:
        point.co *= 1.1
    for frame, value in ((first, 0.0), (last, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    # The flesh of a Mesh Cache shares the mesh's shape keys, and so lets Blender evaluate them.
    armature.fascicle.attachment = "SHAPE_KEYS"

    def written():
        target = os.path.join(said["folder"], "character.glb")
        try:
            character.write_character(target, bpy.context, armature, [mesh], armature.fascicle, first, last, 24.0)
        except Exception as error:
            return repr(error)
        with open(target, "rb") as file:
            return hashlib.sha256(file.read()).hexdigest()

    def move():
        armature.location = (0.7, -1.3, 0.4)

    def key_as_object():
        for frame in (first, last):
            armature.location.x = frame
            armature.keyframe_insert("location", frame=frame)

    def hide_armature():
        armature.hide_viewport = True

    result = {"pairs": {}}
    assert bpy.ops.fascicle.bake() == {"FINISHED"}
    result["as baked"] = written()
    for change in (move, key_as_object, hide_armature):
        bpy.ops.fascicle.show(bake=armature.animation_data.action.name)
        change()
        was_hidden = [mesh.hide_viewport, armature.hide_viewport]
        with_flesh = written()
        assert [mesh.hide_viewport, armature.hide_viewport] == was_hidden and mesh.hide_viewport
        armature.hide_viewport = False
        bpy.ops.fascicle.show(bake="")
        bpy.context.scene.frame_set(last)
        result["pairs"][change.__name__] = [with_flesh, written()]
    return result


def two_armature_modifiers(path, said):
    """The flesh of a mesh that the armature moves by two modifiers."""
    armature = open_character(path, said)
    mesh = next(obj for obj in bpy.data.objects if obj.type == "MESH")
    mesh.modifiers.new("Second", "ARMATURE").object = armature
    mesh.modifiers.new("Later", "SUBSURF").show_viewport = False
    assert bpy.ops.fascicle.bake() == {"FINISHED"}
    error, frames = measure_exact(armature, baked_folder(said), frames_of(said)[0])
    return {"error": error, "frames": frames, "modifiers": [found.type for found in flesh_of(armature)[0].modifiers],
            "of_the_mesh": [found.type for found in mesh.modifiers]}


def hidden_meshes(path, said):
    """Copies of the mesh that the user hides in each way, beside the mesh itself: what is baked, twice; how they are
    hidden before, with the flesh and after; and what is said where the mesh is hidden too."""
    armature = open_character(path, said)
    mesh = next(obj for obj in bpy.data.objects if obj.type == "MESH")
    hat = cut_in_two(mesh, 0.05)
    mesh.name, hat.name = "body", "hat"

    def copy_in(name, collection):
        copy = mesh.copy()
        copy.name = name
        collection.objects.link(copy)
        return copy

    first = mesh.users_collection[0]
    ways = ("in_collection", "in_excluded_collection", "in_collection_of_proxies")
    collections = {name: bpy.data.collections.new(name) for name in ways}
    for collection in collections.values():
        bpy.context.scene.collection.children.link(collection)
    copies = [copy_in(name, collection) for name, collection in collections.items()]
    collections["in_collection"].hide_viewport = True
    bpy.context.view_layer.layer_collection.children["in_excluded_collection"].exclude = True
    collections["in_collection_of_proxies"].hide_render = True
    copies += [copy_in(name, first) for name in ("in_view", "in_renders", "by_eye")]
    bpy.data.objects["in_view"].hide_viewport = True
    bpy.data.objects["in_renders"].hide_render = True
    bpy.context.view_layer.update()
    bpy.data.objects["by_eye"].hide_set(True)

    def state():
        return [[obj.name, obj.hide_viewport, obj.hide_render] for obj in copies]

    result = {"before": state(), "baked": []}
    for _ in range(2):
        assert bpy.ops.fascicle.bake() == {"FINISHED"}
        result["baked"].append([obj["fascicle_mesh"].name for obj in flesh_of(armature)])
        # The second bake is without it.
        hat.hide_set(True)
    result.update(with_flesh=state(), hat=hat.hide_viewport or hat.hide_render)
    hat.hide_set(False)
    result["flesh_shown"] = not any(obj.hide_viewport or obj.hide_render for obj in flesh_of(armature))
    bpy.ops.fascicle.clear()
    result.update(after=state(), shown=not mesh.hide_viewport and not mesh.hide_render)
    mesh.hide_viewport = hat.hide_viewport = True
    try:
        bpy.ops.fascicle.bake()
    except RuntimeError as error:
        result["all hidden"] = str(error)
    return result


def renamed(path, said):
    """Renames the armature and the mesh after a bake, then shows and clears; also with names in the custom properties,
    as earlier add-ons wrote them."""
    armature = open_character(path, said)
    mesh = next(obj for obj in bpy.data.objects if obj.type == "MESH")
    assert bpy.ops.fascicle.bake() == {"FINISHED"}
    collection = next(found for found in bpy.data.collections if found.get("fascicle_bake"))
    flesh, = collection.objects
    armature.name, mesh.name = "Renamed", "Renamed mesh"
    bpy.ops.fascicle.show(bake="")
    result = {"skinned": not mesh.hide_viewport}
    bpy.ops.fascicle.show(bake=collection["fascicle_bake"])
    result["hidden"] = mesh.hide_viewport
    # The panel of the flesh is that of its armature.
    bpy.context.view_layer.objects.active = flesh
    result["panel"] = bpy.ops.fascicle.clear.poll()
    collection["fascicle_armature"], flesh["fascicle_mesh"] = armature.name, mesh.name
    bpy.context.view_layer.objects.active = armature
    assert bpy.ops.fascicle.clear() == {"FINISHED"}
    result["shown"] = not mesh.hide_viewport and not mesh.hide_render
    result["left"] = [obj.name for obj in bpy.data.objects if obj.get("fascicle_mesh")]
    return result


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


def attributes_of(path):
    """The attributes of our own in a character's file, by name."""
    with open(path, "rb") as file:
        data = file.read()
    length, = struct.unpack_from("<I", data, 12)
    document = json.loads(data[20:20 + length])
    attributes = document["meshes"][0]["primitives"][0]["attributes"]

    def values(name):
        accessor = document["accessors"][attributes[name]]
        view = document["bufferViews"][accessor["bufferView"]]
        return list(struct.unpack_from("<%df" % accessor["count"], data, 28 + length + view["byteOffset"]))

    return {name: values(name) for name in attributes if name.startswith("_")}


def groups_of_like_names(path, said):
    """Painted layers of groups whose names differ only in what an attribute's name has not; each group has one vertex
    of its own. The vertices that each layer's attribute marks, in the layers' order."""
    from fascicle import character, settings as chosen
    armature = open_character(path, said)
    settings = armature.fascicle
    mesh = next(obj for obj in bpy.data.objects if obj.type == "MESH")
    # The first group has two layers.
    for name in ("Fat.L", "Fat_L", "fat l", "\u0436\u0438\u0440", "\u0442\u0430\u0437", "Fat_L_2", "Fat.L"):
        if name not in mesh.vertex_groups:
            group = mesh.vertex_groups.new(name=name)
            group.add([group.index], 1.0, "REPLACE")
        settings.layers.add().group = name
    target = os.path.join(bpy.app.tempdir, "character.glb")
    character.write_character(target, bpy.context, armature, [mesh], settings, 1, 1, 24.0)
    attributes = attributes_of(target)
    names = re.findall('attribute = "(.*?)"', chosen.layers_text(settings))
    return {"names": names, "legal": all(re.fullmatch("_[A-Z0-9_]+", name) for name in names),
            "marked": [[mesh.vertex_groups[vertex].name for vertex, value in enumerate(attributes[name]) if value]
                       for name in names],
            "groups": [layer.group for layer in settings.layers]}


def painted(path, said):
    """Groups and layers from the panel, and what reached the program: the character's file and the manifest."""
    from fascicle import operators, settings as chosen
    armature = open_character(path, said)
    settings = armature.fascicle
    mesh = next(obj for obj in bpy.data.objects if obj.type == "MESH")
    count = len(mesh.data.vertices)
    for name, where in (("hard", range(0, count // 4)), ("belly fat", range(count // 4, count // 2))):
        mesh.vertex_groups.new(name=name).add(list(where), 1.0, "REPLACE")
    mesh.vertex_groups["belly fat"].add([0], 0.25, "REPLACE")
    mesh.vertex_groups.new(name="soft").add(list(range(count // 2)), 0.5, "REPLACE")
    settings.bone_group, settings.stiffness_group = "hard", "soft"
    bpy.context.view_layer.objects.active = mesh
    mesh.vertex_groups.active_index = mesh.vertex_groups["belly fat"].index
    bpy.ops.fascicle.edit_list(which="layers", what="ADD")
    settings.layers[0].youngs_modulus = 5.5
    result = {"layer": settings.layers[0].group}
    bpy.ops.fascicle.preset(wish="CARTOON")
    result["cartoon"] = [settings.softness, settings.exaggerate, settings.density]
    bpy.ops.fascicle.preset(wish="HEAVIER")
    result["heavier"] = [settings.softness, settings.exaggerate, settings.density]
    result["options"] = chosen.program_options(settings)
    assert bpy.ops.fascicle.bake() == {"FINISHED"}
    folder = baked_folder(said)
    with open(os.path.join(folder, "manifest.json")) as file:
        result["manifest"] = json.load(file)
    character, = glob.glob(folder + "-*.glb")
    result["count"] = count
    result["attributes"] = attributes_of(character)
    return result


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
found = globals()[check](character, options(arguments[3:]))
if isinstance(found, dict):
    finish(target, found)
else:
    bpy.app.timers.register(functools.partial(tick, found, target), first_interval=0.5, persistent=True)
