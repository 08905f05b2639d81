"""blender --background --factory-startup --python measure_blender.py -- RESULT FOLDER...

Loads each bake with its own import_blender.py in every format that this Blender reads, evaluates every frame, and
compares world-space vertices with surface.pc2, which is decoded here. Writes the largest distance, relative to the
body's height, for each folder and format to RESULT as JSON."""
import json
import os
import runpy
import struct
import sys

import bpy


def samples_of(path):
    with open(path, 'rb') as file:
        magic, version, points, first, step, samples = struct.unpack('<12siiffi', file.read(32))
        assert magic == b'POINTCACHE2\0' and version == 1 and first == 0 and step == 1
        for _ in range(samples):
            values = struct.unpack('<%df' % (3 * points), file.read(12 * points))
            yield [values[i:i + 3] for i in range(0, 3 * points, 3)]


def vertices_now(objects):
    """World-space vertices in the files' axes: Blender's z is their y."""
    graph = bpy.context.evaluated_depsgraph_get()
    result = []
    for found in objects:
        evaluated = found.evaluated_get(graph)
        mesh = evaluated.to_mesh()
        for vertex in mesh.vertices:
            x, y, z = evaluated.matrix_world @ vertex.co
            result.append((x, z, -y))
        evaluated.to_mesh_clear()
    return result


def is_body(found):
    return found.type == 'MESH' and (found.data.shape_keys or
                                     any(m.type == 'MESH_CACHE' for m in found.modifiers))


def measure(folder, kind):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    script = runpy.run_path(os.path.join(folder, 'import_blender.py'))
    body = sorted(filter(is_body, script['load'](kind)), key=lambda found: found.name)
    materials = {slot.material for found in body for slot in found.material_slots if slot.material}
    images = [node.image for material in materials if material.node_tree
              for node in material.node_tree.nodes if node.type == 'TEX_IMAGE' and node.image]
    smooth = all(polygon.use_smooth for found in body for polygon in found.data.polygons)
    largest, height, frames = 0.0, 0.0, 0
    for frame, wanted in enumerate(samples_of(os.path.join(folder, 'surface.pc2'))):
        bpy.context.scene.frame_set(frame)
        found = vertices_now(body)
        assert len(found) == len(wanted), '%d vertices, not %d' % (len(found), len(wanted))
        if frame == 0:
            height = max(p[1] for p in wanted) - min(p[1] for p in wanted)
        largest = max(largest, max(max(abs(a - b) for a, b in zip(p, q)) for p, q in zip(found, wanted)))
        frames += 1
    scene = bpy.context.scene
    return {'error': largest / height, 'frames': frames, 'smooth': smooth,
            'materials': sorted(material.name for material in materials),
            'images': sum(image.size[0] > 0 for image in images),
            'uvs': all(bool(found.data.uv_layers) for found in body), 'first': scene.frame_start,
            'last': scene.frame_end, 'fps': scene.render.fps / scene.render.fps_base}


result, *folders = sys.argv[sys.argv.index('--') + 1:]
report = {folder: {kind: measure(folder, kind) for kind in ('pc2', 'mdd', 'glb')} for folder in folders}
with open(result, 'w') as file:
    json.dump(report, file)
