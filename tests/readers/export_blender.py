"""blender --background --factory-startup --python export_blender.py -- FOLDER

Makes a post of 1.8 m on two bones that are placed and rotated as artists leave them, bend in a clip of 25 frames, with
a blend shape that swells the post. Writes it as FOLDER/post.glb, .fbx and, without the shape, .dae. Every frame is a
key in all three, so that nothing is interpolated."""
import math
import sys

import numpy

numpy.bool = bool  # this Blender's FBX exporter still uses it
import bpy  # noqa: E402

folder = sys.argv[sys.argv.index('--') + 1]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.fps = 24
scene.frame_start, scene.frame_end = 0, 24

rig = bpy.data.objects.new('Rig', bpy.data.armatures.new('Rig'))
scene.collection.objects.link(rig)
bpy.context.view_layer.objects.active = rig
bpy.ops.object.mode_set(mode='EDIT')
lower = rig.data.edit_bones.new('lower')
lower.head, lower.tail = (0, 0, 0), (0, 0.1, 0.9)
upper = rig.data.edit_bones.new('upper')
upper.head, upper.tail, upper.parent, upper.roll = (0, 0.1, 0.9), (0, 0, 1.8), lower, 0.4
bpy.ops.object.mode_set(mode='OBJECT')

rings, sides = 13, 8
points = [(0.15 * math.cos(2 * math.pi * s / sides), 0.1 * math.sin(2 * math.pi * s / sides), 1.8 * r / (rings - 1))
          for r in range(rings) for s in range(sides)]
faces = [(r * sides + s, r * sides + (s + 1) % sides, (r + 1) * sides + (s + 1) % sides, (r + 1) * sides + s)
         for r in range(rings - 1) for s in range(sides)]
faces += [tuple(reversed(range(sides))), tuple(range((rings - 1) * sides, rings * sides))]
mesh = bpy.data.meshes.new('Post')
mesh.from_pydata(points, [], faces)
post = bpy.data.objects.new('Post', mesh)
scene.collection.objects.link(post)
groups = [post.vertex_groups.new(name=name) for name in ('lower', 'upper')]
for index, point in enumerate(points):
    share = min(max(point[2] / 1.8 * 2 - 0.5, 0), 1)
    for group, weight in zip(groups, (1 - share, share)):
        if weight > 0:
            group.add([index], weight, 'REPLACE')
post.shape_key_add(name='Basis')
bulge = post.shape_key_add(name='bulge')
for index, point in enumerate(points):
    bulge.data[index].co.x = 1.5 * point[0]
mesh.shape_keys.animation_data_create().action = bpy.data.actions.new('swell')
for frame in range(25):
    bulge.value = frame / 24
    bulge.keyframe_insert('value', frame=frame)
post.parent = rig
post.modifiers.new('Armature', 'ARMATURE').object = rig

rig.location, rig.rotation_euler = (0.3, -0.2, 0.1), (0, 0, 0.7)
bone = rig.pose.bones['upper']
bone.rotation_mode = 'XYZ'
rig.animation_data_create().action = bpy.data.actions.new('bend')
for frame in range(25):
    bone.rotation_euler = (1.2 * math.sin(frame / 24 * math.pi), 0.3 * frame / 24, 0)
    bone.keyframe_insert('rotation_euler', frame=frame)
    rig.pose.bones['lower'].location = (0, 0.2 * math.sin(frame / 24 * 2 * math.pi), 0)
    rig.pose.bones['lower'].keyframe_insert('location', frame=frame)
scene.frame_set(12)  # saved in the middle of the clip, as files often are

bpy.ops.export_scene.gltf(filepath=folder + '/post.glb')
bpy.ops.export_scene.fbx(filepath=folder + '/post.fbx', add_leaf_bones=False, bake_anim_simplify_factor=0)
post.shape_key_clear()  # or this Blender would bake it into the mesh
bpy.ops.wm.collada_export(filepath=folder + '/post.dae')
