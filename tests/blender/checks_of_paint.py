"""Checks of in_blender.py: painted groups, layers and presets."""

import glob
import json
import os
import re
import struct

import bpy

from opened_character import baked_folder, open_character


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
    from fascicle import settings as chosen
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
