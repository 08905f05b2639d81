"""Drives a body by poses made here: its joints nod to and fro, and stop. Flesh goes on.

    drive_by_poses.py SCENE OUT.npy [FRAMES]

Writes the surface of each frame, float32 of (frames, vertices, 3), in metres.
"""

import sys

import numpy as np

import fascicle


def turned(pose, angle):
    """The whole pose turned about a horizontal axis through its first joint, by an angle in radians."""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.eye(4)
    turn[:3, :3] = [[c, -s, 0], [s, c, 0], [0, 0, 1]]
    to, back = np.eye(4), np.eye(4)
    back[:3, 3] = pose[0, :3, 3]
    to[:3, 3] = -back[:3, 3]
    return back @ turn @ to @ pose


def main(name, out, frames=40):
    scene = fascicle.Scene(name)
    model = fascicle.Model(scene)
    solver = fascicle.Solver(model)
    rest = solver.clip_pose(0)
    solver.start_pose(rest)

    surface = np.empty((frames, model.surface_vertex_count, 3), np.float32)
    speeds = []
    for frame in range(frames):
        time = min(frame + 1, frames // 2) / scene.fps  # holds still in the second half
        solver.step_pose(turned(rest, 0.2 * np.sin(2 * np.pi * 2 * time)))
        solver.world_surface(surface[frame])  # straight into its place
        speeds.append(float(solver.unit * np.linalg.norm(solver.velocities, axis=1).max()))
    np.save(out, surface)
    print(f"{scene.name}: {frames} frames, fastest {max(speeds):.2f} m/s, at the end {speeds[-1]:.2f} m/s")
    return surface


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], *map(int, sys.argv[3:]))
