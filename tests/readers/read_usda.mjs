// node read_usda.mjs FILE: reads USD's text format with two third-party parsers. tinyusdz, strict and typed, must
// accept the whole file; three.js gives the values of samples. Prints one JSON object.
import fs from 'node:fs';
import { createRequire } from 'node:module';
import { USDAParser } from 'three/examples/jsm/loaders/usd/USDAParser.js';

const file = fs.readFileSync(process.argv[2]);

// The WebAssembly of tinyusdz is built for browsers and checks for one.
process.type = 'renderer';
globalThis.window = globalThis;
const find = createRequire(import.meta.url).resolve;
const program = fs.readFileSync(find('tinyusdz/tinyusdz.wasm'));
// The file is an ES module. Older versions of node only go by its name, so copy it to .mjs.
const named = new URL(`./tinyusdz-${process.pid}.mjs`, import.meta.url);
fs.copyFileSync(find('tinyusdz/tinyusdz.js'), named);
const module = await import(named);
fs.unlinkSync(named);
const tinyusdz = await module.default({
  instantiateWasm: (imports, done) => {
    WebAssembly.instantiate(program, imports).then(({ instance, module }) => done(instance, module));
    return {};
  },
});
const stage = new tinyusdz.TinyUSDZLoaderNative();
if (!stage.loadFromBinary(new Uint8Array(file), 'surface.usda')) throw new Error(stage.error());
const layer = new tinyusdz.TinyUSDZLoaderNative();
if (!layer.loadAsLayerFromBinary(new Uint8Array(file), 'surface.usda')) throw new Error(layer.error());

// The fields of every prim and attribute, with typed arrays as plain arrays.
const plain = (value) => {
  if (ArrayBuffer.isView(value)) return Array.from(value);
  if (value && value.times) return { times: Array.from(value.times), values: value.values.map(plain) };
  return value;
};
const parsed = new USDAParser().parseData(file.toString()).specsByPath;
const specs = Object.fromEntries(Object.entries(parsed).map(([path, spec]) => [
  path, Object.fromEntries(Object.entries(spec.fields).map(([name, value]) => [name, plain(value)])),
]));
process.stdout.write(JSON.stringify({
  layer: layer.layerToString(),
  meshes: stage.numMeshes(),
  first_points: Array.from(stage.getMesh(0).points),
  stage: specs['/'],
  specs,
}));
