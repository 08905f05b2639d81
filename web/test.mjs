// The unit tests that stand beside the sources, bundled for node and run by its own runner.
import { readdirSync } from "node:fs";
import { join } from "node:path";
import { spawnSync } from "node:child_process";
import { build } from "esbuild";

const tests = readdirSync("src", { recursive: true })
  .filter((name) => name.endsWith(".test.ts"))
  .map((name) => join("src", name));
await build({
  entryPoints: tests,
  outbase: "src",
  outdir: "tests-built",
  outExtension: { ".js": ".mjs" },
  bundle: true,
  platform: "node",
  format: "esm",
  target: "node18",
});
const built = tests.map((name) => join("tests-built", name.replace(/^src./, "").replace(/\.ts$/, ".mjs")));
process.exit(spawnSync(process.execPath, ["--test", ...built], { stdio: "inherit" }).status ?? 1);
