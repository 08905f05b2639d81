"""A character of Blender as glTF: its meshes vertex for vertex in Blender's order, its deforming bones as joints with a
key a frame, as Blender evaluates them with all constraints and drivers.

Blender's own exporter splits vertices at seams and materials; then a bake's vertices would not be the mesh's. Metres,
Y up: the scene's unit scale is taken out here and put back by `attach`."""

import contextlib
import itertools
import re
from array import array

from mathutils import Matrix

from . import gltf
from .problem import Problem

# (x, y, z) of Blender is (x, z, -y) of glTF.
TURN = Matrix(((1, 0, 0, 0), (0, 0, 1, 0), (0, -1, 0, 0), (0, 0, 0, 1)))
# A matrix is a place, a turn and a scale within this share of its largest entry, or it shears.
SHEAR = 1e-4
# A custom property of an object that shows a bake: the mesh it stands for.
FLESH = "fascicle_mesh"
# A custom property of a mesh in whose place a bake is shown: how its user had hidden it, in the view and in renders.
HIDDEN = "fascicle_hidden"
# How an object or a bone stands. The mode comes first, as a change of it converts the rotations.
PLACEMENT = ("rotation_mode", "location", "rotation_quaternion", "rotation_euler", "rotation_axis_angle", "scale")
DELTAS = ("delta_location", "delta_rotation_quaternion", "delta_rotation_euler", "delta_scale")
LAYER_NUMBERS = {"bone": 1, "muscle": 2, "fat": 3}


def metres_per_unit(scene):
    units = scene.unit_settings
    return units.scale_length if units.system != "NONE" else 1.0


def armature_modifier(mesh, armature):
    """The number of the mesh's modifier that `armature` moves it by; -1 where it does so as its parent, else None."""
    for number, modifier in enumerate(mesh.modifiers):
        if modifier.type == "ARMATURE" and modifier.object == armature and modifier.show_viewport:
            return number
    return -1 if mesh.parent == armature and mesh.parent_type == "ARMATURE" else None


def hidden_by_user(mesh):
    """Whether its user hides a mesh in the view, and in renders."""
    return [bool(value) for value in mesh.get(HIDDEN, (mesh.hide_viewport, mesh.hide_render))]


def _shown_collections(layer):
    """Those of a view layer that are hidden neither themselves nor by one above."""
    collection = layer.collection
    if layer.hide_viewport or collection.hide_viewport or collection.hide_render:
        return
    if not layer.exclude:
        yield collection
    for child in layer.children:
        yield from _shown_collections(child)


def moved_meshes(scene, armature):
    """The meshes that an armature moves, by name. Flesh that was baked is none of them."""
    return sorted((found for found in scene.objects
                   if found.type == "MESH" and FLESH not in found.keys()
                   and armature_modifier(found, armature) is not None), key=lambda found: found.name)


def meshes_of(context, armature):
    """Of the meshes that an armature moves those that are baked: the ones that the user shows. Coarser copies and cages
    are hidden."""
    layer = context.view_layer
    shown = list(_shown_collections(layer.layer_collection))
    return [mesh for mesh in moved_meshes(context.scene, armature)
            if not any(hidden_by_user(mesh)) and any(found.objects.get(mesh.name) == mesh for found in shown)
            and not mesh.hide_get(view_layer=layer)]


def attribute_names(layers):
    """The glTF attribute of each vertex group that is a layer of its own: a different one for each group."""
    names = {}
    for group in dict.fromkeys(layer.group for layer in layers if layer.group):
        # Attributes have capitals and digits alone, so different groups may want the same.
        wanted = "_GROUP_" + re.sub("[^A-Z0-9]", "_", group.upper())
        numbered = ("%s_%d" % (wanted, number) for number in itertools.count(2))
        names[group] = next(name for name in itertools.chain([wanted], numbered) if name not in names.values())
    return names


@contextlib.contextmanager
def pose_kept(armature):
    """Evaluating an action overwrites the pose, also where nothing is keyed in the open action. Here the placements of
    the armature and its bones come back, their custom numbers, and the influences of their constraints."""
    owners = [armature, *armature.pose.bones]
    kept = [(owner, name, getattr(owner, name)[:]) for owner in owners for name in PLACEMENT]
    kept += [(armature, name, getattr(armature, name)[:]) for name in DELTAS]
    switches = [(owner, key, value.to_list() if hasattr(value, "to_list") else value) for owner in owners
                for key, value in owner.items() if isinstance(value, (int, float)) or hasattr(value, "to_list")]
    influences = [(constraint, constraint.influence) for owner in owners for constraint in owner.constraints]
    try:
        yield
    finally:
        for owner, name, value in kept:
            setattr(owner, name, value)
        for owner, key, value in switches:
            owner[key] = value
        for constraint, value in influences:
            constraint.influence = value
        armature.update_tag()


class _Skeleton:
    """The deforming bones of an armature as joints: a joint's parent is the nearest deforming bone above."""

    def __init__(self, armature):
        self.bones = [bone for bone in armature.data.bones if bone.use_deform]
        if not self.bones:
            raise Problem("No bone of %s deforms anything" % armature.name)
        self.numbers = {bone.name: number for number, bone in enumerate(self.bones)}
        self.parents = []
        for bone in self.bones:
            above = bone.parent
            while above and above.name not in self.numbers:
                above = above.parent
            self.parents.append(self.numbers[above.name] if above else -1)

    def locals_of(self, worlds, frame):
        """(translation, rotation, scale) of each joint in its parent; raises Problem where one is sheared, or has no
        place in a parent without extent."""
        result = []
        for number, parent in enumerate(self.parents):
            try:
                matrix = worlds[number] if parent < 0 else worlds[parent].inverted() @ worlds[number]
            except ValueError as error:
                raise Problem("Bone %s is scaled to 0 in frame %d, by itself or by a bone above it, and bones below it "
                              "are baked too; give it a small scale, such as 0.001"
                              % (self.bones[parent].name, frame)) from error
            parts = matrix.decompose()
            again = Matrix.LocRotScale(*parts)
            largest = max(abs(x) for row in matrix for x in row)
            if max(abs(a - b) for p, q in zip(matrix, again) for a, b in zip(p, q)) > SHEAR * largest:
                raise Problem("Bone %s is sheared by its parent's uneven scale, which glTF does not know; apply the "
                              "scale" % self.bones[number].name)
            result.append(parts)
        return result


def _positions(vertices, matrix):
    return [matrix @ vertex.co for vertex in vertices]


def _flat(vectors):
    return array("f", (x for vector in vectors for x in vector))


def _weights_by_group(mesh, group_name, elsewhere=0.0):
    """The weight of each vertex in a group; `elsewhere` outside it, and where there is no such group."""
    group = mesh.vertex_groups.get(group_name)
    values = array("f", [elsewhere]) * len(mesh.data.vertices)
    if group:
        for vertex in mesh.data.vertices:
            for member in vertex.groups:
                if member.group == group.index:
                    values[vertex.index] = member.weight
    return values


def _influences(mesh, skeleton):
    """Sets of four joints and weights a vertex, as many as the mesh needs; a vertex's weights sum to 1."""
    joints = {group.index: skeleton.numbers[group.name] for group in mesh.vertex_groups
              if group.name in skeleton.numbers}
    members = [sorted(((m.weight, joints[m.group]) for m in vertex.groups if m.group in joints and m.weight > 0.0),
                      reverse=True) for vertex in mesh.data.vertices]
    most = max((len(found) for found in members), default=0)
    if most == 0:
        raise Problem("No vertex of %s has a weight of a deforming bone; the program needs vertex groups, not envelopes"
                      % mesh.name)
    sets = []
    for first in range(0, most, 4):
        numbers, weights = array("H", bytes(8 * len(members))), array("f", bytes(16 * len(members)))
        for vertex, found in enumerate(members):
            whole = sum(weight for weight, _ in found)
            for place, (weight, joint) in enumerate(found[first:first + 4]):
                numbers[4 * vertex + place], weights[4 * vertex + place] = joint, weight / whole
        sets.append((numbers, weights))
    return sets


def _painted(mesh, settings):
    """The glTF attributes that the program reads, by their names, of the groups that are chosen."""
    attributes = {}
    layers = {layer: _weights_by_group(mesh, getattr(settings, layer + "_group")) for layer in LAYER_NUMBERS
              if getattr(settings, layer + "_group")}
    if layers:
        numbers = array("f", bytes(4 * len(mesh.data.vertices)))
        for vertex in range(len(numbers)):
            layer = max(layers, key=lambda name: layers[name][vertex])
            if layers[layer][vertex] >= 0.5:
                numbers[vertex] = LAYER_NUMBERS[layer]
        attributes["_LAYER"] = numbers
    # Vertices outside the group are as stiff as their layer.
    for attribute, group, elsewhere in (("_RIGID", settings.rigid_group, 0.0),
                                        ("_STIFFNESS", settings.stiffness_group, 1.0)):
        if group:
            attributes[attribute] = _weights_by_group(mesh, group, elsewhere)
    for group, attribute in attribute_names(settings.layers).items():
        attributes[attribute] = _weights_by_group(mesh, group)
    return attributes


def _moving_keys(mesh):
    """Shape keys beside the basis."""
    keys = mesh.data.shape_keys
    if not keys:
        return []
    if not keys.use_relative:
        raise Problem("%s has absolute shape keys, which glTF does not know" % mesh.name)
    return [key for key in keys.key_blocks if key != keys.reference_key and not key.mute]


def _check(mesh, armature):
    number = armature_modifier(mesh, armature)
    for modifier in list(mesh.modifiers)[:max(number, 0)]:
        if modifier.show_viewport:
            raise Problem("%s: the modifier %s stands before the armature's; apply it, or move it below"
                          % (mesh.name, modifier.name))
    if mesh.data.is_editmode:
        raise Problem("%s is in edit mode; leave it" % mesh.name)
    if not mesh.data.polygons:
        raise Problem("%s has no faces" % mesh.name)


def _add_mesh(document, mesh, skeleton, settings, metres):
    """The number of its node."""
    data = mesh.data
    to_file = TURN @ Matrix.Scale(metres, 4) @ mesh.matrix_world
    rest = data.shape_keys.reference_key.data if data.shape_keys else data.vertices
    places = _positions(rest, to_file)
    data.calc_loop_triangles()
    indices = array("I", bytes(12 * len(data.loop_triangles)))
    data.loop_triangles.foreach_get("vertices", indices)
    attributes = {"POSITION": document.accessor(_flat(places), "VEC3")}
    for number, (joints, weights) in enumerate(_influences(mesh, skeleton)):
        attributes["JOINTS_%d" % number] = document.accessor(joints, "VEC4", gltf.UNSIGNED_SHORT)
        attributes["WEIGHTS_%d" % number] = document.accessor(weights, "VEC4")
    for name, values in _painted(mesh, settings).items():
        attributes[name] = document.accessor(values, "SCALAR")
    entry = {"name": mesh.name, "primitives": [{
        "attributes": attributes, "indices": document.accessor(indices, "SCALAR", gltf.UNSIGNED_INT)}]}
    keys = _moving_keys(mesh)
    if keys:
        entry["primitives"][0]["targets"] = []
        for key in keys:
            share = _weights_by_group(mesh, key.vertex_group) if key.vertex_group else [1.0] * len(places)
            base = _positions(key.relative_key.data, to_file)
            moves = [(new - old) * part for new, old, part in zip(_positions(key.data, to_file), base, share)]
            entry["primitives"][0]["targets"].append({"POSITION": document.accessor(_flat(moves), "VEC3")})
        entry["weights"] = [key.value for key in keys]
        entry["extras"] = {"targetNames": [key.name for key in keys]}
    return document.add("nodes", {"name": mesh.name, "mesh": document.add("meshes", entry), "skin": 0})


def write_character(path, context, armature, meshes, settings, first, last, fps):
    """Writes the meshes on their armature, with one clip: Blender's frames `first` to `last`, the first at 0 s.
    Raises Problem, and then writes nothing. Blender's frame is the same afterwards."""
    scene = context.scene
    if armature.data.pose_position != "POSE":
        raise Problem("%s is in its rest position; set it to Pose Position" % armature.name)
    for mesh in meshes:
        _check(mesh, armature)
    before = scene.frame_current
    hidden = [obj for obj in (armature, *meshes) if obj.hide_viewport]
    try:
        # Blender does not evaluate what is hidden, such as meshes that an earlier bake is shown in place of.
        for obj in hidden:
            obj.hide_viewport = False
        context.view_layer.update()
        document = _document_of(context, armature, meshes, settings, first, last, fps)
    finally:
        for obj in hidden:
            obj.hide_viewport = True
        scene.frame_set(before)
    document.write(path)


def _check_extent(armature, world, frame):
    if world.determinant() == 0.0:
        raise Problem("%s is scaled to 0 in frame %d; its bones have no place there. Give it a small scale, such as "
                      "0.001" % (armature.name, frame))


def _document_of(context, armature, meshes, settings, first, last, fps):
    scene = context.scene
    metres = metres_per_unit(scene)
    skeleton = _Skeleton(armature)
    document = gltf.Document()
    to_file = TURN @ Matrix.Scale(metres, 4)
    from_file = to_file.inverted()
    scene.frame_set(first)
    home = armature.matrix_world.copy()
    _check_extent(armature, home, first)
    apart = [home.inverted_safe() @ mesh.matrix_world for mesh in meshes]
    bind = [to_file @ home @ bone.matrix_local @ from_file for bone in skeleton.bones]

    for bone, (place, turn, scale) in zip(skeleton.bones, skeleton.locals_of(bind, first)):
        document.add("nodes", {"name": bone.name, "translation": list(place), "scale": list(scale),
                               "rotation": [turn.x, turn.y, turn.z, turn.w]})
    for number, parent in enumerate(skeleton.parents):
        above = document.json["nodes"][parent] if parent >= 0 else document.json["scenes"][0]
        above.setdefault("children" if parent >= 0 else "nodes", []).append(number)
    inverses = array("f", (matrix[row][column] for matrix in (world.inverted() for world in bind)
                           for column in range(4) for row in range(4)))
    document.add("skins", {"joints": list(range(len(bind))),
                           "inverseBindMatrices": document.accessor(inverses, "MAT4")})
    nodes = [_add_mesh(document, mesh, skeleton, settings, metres) for mesh in meshes]
    document.json["scenes"][0]["nodes"] += nodes

    tracks = [(array("f"), array("f"), array("f")) for _ in skeleton.bones]
    weights = [array("f") for _ in meshes]
    turns = [None] * len(skeleton.bones)
    for frame in range(first, last + 1):
        scene.frame_set(frame)
        graph = context.evaluated_depsgraph_get()
        evaluated = armature.evaluated_get(graph)
        _check_extent(armature, evaluated.matrix_world, frame)
        world = to_file @ evaluated.matrix_world
        for mesh, home_of_mesh in zip(meshes, apart):
            off = (evaluated.matrix_world @ home_of_mesh) - mesh.evaluated_get(graph).matrix_world
            if max(abs(x) for row in off for x in row) > SHEAR * max(1.0, max(abs(x) for row in world for x in row)):
                raise Problem("%s does not go along with %s, which moves as an object; make the armature its parent"
                              % (mesh.name, armature.name))
        posed = [world @ evaluated.pose.bones[bone.name].matrix @ from_file for bone in skeleton.bones]
        for number, (place, turn, scale) in enumerate(skeleton.locals_of(posed, frame)):
            if turns[number] is not None:
                turn.make_compatible(turns[number])
            turns[number] = turn
            tracks[number][0].extend(place)
            tracks[number][1].extend((turn.x, turn.y, turn.z, turn.w))
            tracks[number][2].extend(scale)
        for mesh, values in zip(meshes, weights):
            values.extend(key.value for key in _moving_keys(mesh))

    times = document.accessor(array("f", ((frame - first) / fps for frame in range(first, last + 1))), "SCALAR")
    clip = {"name": "bake", "channels": [], "samplers": []}

    def add_track(node, path, values, kind):
        clip["samplers"].append({"input": times, "output": document.accessor(values, kind), "interpolation": "LINEAR"})
        clip["channels"].append({"sampler": len(clip["samplers"]) - 1, "target": {"node": node, "path": path}})

    for number, (places, rotations, scales) in enumerate(tracks):
        add_track(number, "translation", places, "VEC3")
        add_track(number, "rotation", rotations, "VEC4")
        add_track(number, "scale", scales, "VEC3")
    for node, values in zip(nodes, weights):
        if values:
            add_track(node, "weights", values, "SCALAR")
    document.add("animations", clip)
    return document
