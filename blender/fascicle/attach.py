"""What a bake becomes in Blender: a copy of each mesh that the bake moves, in a collection for each bake. The mesh that
the armature moves is hidden beside it and otherwise left alone."""

import os
from array import array

import bpy
from mathutils import Matrix

from . import character, point_cache
from .character import FLESH, HIDDEN
from .problem import Problem

# Custom properties by which what was made here is found again: of a collection its armature and its bake's name.
ARMATURE, BAKE = "fascicle_armature", "fascicle_bake"


def object_at(owner, key):
    """The object that a custom property points to, or names, as it did in files of earlier add-ons; None."""
    found = owner.get(key)
    return bpy.data.objects.get(found) if isinstance(found, str) else found


def collections_of(armature):
    """The collections of an armature's bakes, by name."""
    return [found for found in bpy.data.collections if object_at(found, ARMATURE) == armature]


def _meshes_of(collection):
    """The meshes that a bake's flesh stands for."""
    return list(filter(None, (object_at(flesh, FLESH) for flesh in collection.objects)))


def _unlink_from_all(obj):
    for collection in list(obj.users_collection):
        collection.objects.unlink(obj)


def _flesh_object(mesh, armature, metres, shares_mesh):
    """A copy with all of its looks, which stands where the file's origin is, without what moves the mesh."""
    flesh = mesh.copy()
    if not shares_mesh:
        flesh.data = mesh.data.copy()
        flesh.shape_key_clear()
    flesh.name = mesh.name + " flesh"
    flesh[FLESH] = mesh
    flesh.animation_data_clear()
    flesh.constraints.clear()
    flesh.parent = None
    first = character.armature_modifier(flesh, armature)
    for number, modifier in enumerate(list(flesh.modifiers)):
        # There may be several of the armature.
        is_armatures = modifier.type == "ARMATURE" and modifier.object == armature
        if is_armatures or (first is not None and number < first):
            flesh.modifiers.remove(modifier)
    flesh.matrix_world = Matrix.Scale(1.0 / metres, 4)
    flesh.hide_viewport, flesh.hide_render = character.hidden_by_user(mesh)
    if HIDDEN in flesh.keys():
        del flesh[HIDDEN]
    return flesh


def _add_mesh_cache(flesh, path, first):
    cache = flesh.modifiers.new("fascicle", "MESH_CACHE")
    cache.cache_format = "PC2"
    try:
        cache.filepath = bpy.path.relpath(path) if bpy.data.filepath else path
    except ValueError:  # another drive
        cache.filepath = path
    cache.deform_mode = "OVERWRITE"
    cache.interpolation = "LINEAR"
    cache.time_mode = "FRAME"
    cache.play_mode = "SCENE"
    cache.frame_start = first
    # These two of Blender's names turn Y up into Z up, exactly: (x, y, z) of the file is (x, -z, y).
    cache.forward_axis = "POS_Z"
    cache.up_axis = "NEG_Y"
    # The first of the stack, in the place of the armature; subdivision and the like stay behind it.
    if len(flesh.modifiers) > 1:
        with bpy.context.temp_override(object=flesh):
            bpy.ops.object.modifier_move_to_index(modifier=cache.name, index=0)


def _add_shape_keys(flesh, path, first):
    """A key a frame, each shown at its frame alone."""
    editing = bpy.context.preferences.edit
    before = editing.keyframe_new_interpolation_type
    editing.keyframe_new_interpolation_type = "LINEAR"
    try:
        for number, sample in enumerate(point_cache.samples(path)):
            values = array("f", sample)
            places = array("f", bytes(len(sample)))
            places[0::3], places[2::3] = values[0::3], values[1::3]
            places[1::3] = array("f", (-z for z in values[2::3]))
            if number == 0:
                flesh.data.vertices.foreach_set("co", places)
                flesh.shape_key_add(name="Basis", from_mix=False).data.foreach_set("co", places)
                continue
            key = flesh.shape_key_add(name="frame %d" % (first + number), from_mix=False)
            key.data.foreach_set("co", places)
            for frame, value in ((first + number - 1, 0.0), (first + number, 1.0), (first + number + 1, 0.0)):
                key.value = value
                key.keyframe_insert("value", frame=frame)
        # The last pose stays.
        last = flesh.data.shape_keys.key_blocks[-1]
        last.keyframe_delete("value", frame=first + number + 1)
        flesh.data.update()
    finally:
        editing.keyframe_new_interpolation_type = before


def attach(context, armature, meshes, name, folder, first, kind):
    """Shows the bake in `folder`, whose frame 0 is Blender's frame `first`, in the place of the meshes. `kind` is one
    of settings.ATTACHMENTS. An earlier bake of that name is replaced. Raises Problem, and then nothing has changed."""
    points = os.path.join(folder, point_cache.NAME)
    paths = [points]
    if len(meshes) > 1:
        paths = [os.path.join(folder, point_cache.part_name(number)) for number in range(len(meshes))]
        point_cache.write_parts(points, [(path, len(mesh.data.vertices)) for path, mesh in zip(paths, meshes)])
    for path, mesh in zip(paths, meshes):
        with open(path, "rb") as file:
            found, _ = point_cache.read_head(file, path)
        if found != len(mesh.data.vertices):
            raise Problem("%s has %d vertices and was baked with %d; bake again"
                          % (mesh.name, len(mesh.data.vertices), found))
    earlier = [old for old in collections_of(armature) if old.get(BAKE) == name]
    collection = bpy.data.collections.new("Flesh " + name)
    collection[ARMATURE], collection[BAKE] = armature, name
    context.scene.collection.children.link(collection)
    metres = character.metres_per_unit(context.scene)
    try:
        for path, mesh in zip(paths, meshes):
            flesh = _flesh_object(mesh, armature, metres, kind == "MESH_CACHE")
            _unlink_from_all(flesh)
            collection.objects.link(flesh)
            (_add_mesh_cache if kind == "MESH_CACHE" else _add_shape_keys)(flesh, path, first)
    except BaseException:
        _remove_collection(collection)
        raise
    for old in earlier:
        # The new bake may leave out a mesh of the earlier one.
        for mesh in _meshes_of(old):
            _hide(mesh, False)
        _remove_collection(old)
    collection.name = "Flesh " + name
    show(armature, name)
    return collection


def show(armature, name):
    """Of an armature's bakes this one alone; where `name` is None, the meshes by skinning."""
    found = collections_of(armature)
    replaced = {mesh for collection in found if collection[BAKE] == name for mesh in _meshes_of(collection)}
    for collection in found:
        collection.hide_viewport = collection.hide_render = collection[BAKE] != name
        for mesh in _meshes_of(collection):
            _hide(mesh, mesh in replaced)


def _hide(mesh, hidden):
    if hidden and HIDDEN not in mesh.keys():
        mesh[HIDDEN] = character.hidden_by_user(mesh)
        mesh.hide_viewport = mesh.hide_render = True
    elif not hidden and HIDDEN in mesh.keys():
        mesh.hide_viewport, mesh.hide_render = character.hidden_by_user(mesh)
        del mesh[HIDDEN]


def _remove_collection(collection):
    for flesh in list(collection.objects):
        data = flesh.data
        bpy.data.objects.remove(flesh)
        if data.users == 0:
            bpy.data.meshes.remove(data)
    bpy.data.collections.remove(collection)


def clear(armature):
    """Takes away all that `attach` has added for an armature and shows its meshes again; how many bakes were shown."""
    show(armature, None)
    found = collections_of(armature)
    for collection in found:
        _remove_collection(collection)
    return len(found)
