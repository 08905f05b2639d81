// node read_three.mjs FILE TIME...: what three.js shows of a .glb at these times of its first clip, for each mesh of
// the scene. Prints one JSON object per time: the vertices of each mesh, 3 numbers each.
import fs from 'node:fs';
import * as THREE from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
import { MeshoptDecoder } from 'three/examples/jsm/libs/meshopt_decoder.module.js';

const bytes = fs.readFileSync(process.argv[2]);
const loader = new GLTFLoader();
loader.setMeshoptDecoder(MeshoptDecoder);
const file = await loader.parseAsync(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength), '');

const mixer = new THREE.AnimationMixer(file.scene);
const action = mixer.clipAction(file.animations[0]);
action.setLoop(THREE.LoopOnce, 1);
action.clampWhenFinished = true;
action.play();
const shown = [];
for (const time of process.argv.slice(3)) {
  mixer.setTime(Number(time));
  file.scene.updateMatrixWorld(true);
  const meshes = [];
  file.scene.traverse((mesh) => {
    if (!mesh.isMesh) return;
    const place = new THREE.Vector3();
    const points = [];
    for (let i = 0; i < mesh.geometry.attributes.position.count; ++i) {
      mesh.getVertexPosition(i, place).applyMatrix4(mesh.matrixWorld);
      points.push(place.x, place.y, place.z);
    }
    meshes.push({ name: mesh.name, points });
  });
  shown.push(meshes);
}
process.stdout.write(JSON.stringify(shown));
