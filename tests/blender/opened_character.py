"""A character opened in Blender, and measures of its flesh. Bakes are decoded here, not by the add-on's reader."""

import glob
import os
import struct

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
