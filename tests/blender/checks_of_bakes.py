"""Checks of in_blender.py: what a bake writes, shows and leaves."""

import glob
import hashlib
import os

import bmesh
import bpy

from opened_character import baked_folder, evaluated, flesh_of, frames_of, measure_exact, open_character, samples_of


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
