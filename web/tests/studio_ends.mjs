// Whether a studio outlives the script that started it: node studio_ends.mjs PROGRAM FOLDER SCENE
// FOLDER gets report.json. The script runs itself as the ones that fail and that are killed.
import { spawn } from "node:child_process";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { start_studio } from "./studio_program.mjs";

const [program, folder, scene, end] = process.argv.slice(2);
if (end) {
  const studio = start_studio(program, join(folder, end), [scene]);
  await studio.address;
  console.log(studio.child.pid);
  if (end === "fails") throw new Error("as a test does that finds something wrong");
  await new Promise((done) => setTimeout(done, 60000));
}

const is_there = (pid) => {
  try {
    process.kill(pid, 0);
    return true;
  } catch {
    return false;
  }
};
const report = {};
for (const how of ["fails", "killed"]) {
  const script = spawn(process.execPath, [fileURLToPath(import.meta.url), program, folder, scene, how], {
    stdio: ["ignore", "pipe", "ignore"],
  });
  const ended = new Promise((done) => script.on("exit", done));
  const pid = Number(await new Promise((found) => script.stdout.once("data", (bytes) => found(String(bytes)))));
  report[how] = { was_there: how === "fails" || is_there(pid) };
  if (how === "killed") script.kill("SIGKILL");
  await ended;
  for (let k = 0; k < 100 && is_there(pid); ++k) await new Promise((done) => setTimeout(done, 50));
  report[how].is_there = is_there(pid);
}
writeFileSync(join(folder, "report.json"), JSON.stringify(report, null, 1));
