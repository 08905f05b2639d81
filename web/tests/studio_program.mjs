// `fascicle studio` under way, with its session in FOLDER/session. It ends with this script, however that ends: the
// kernel kills it.
import { spawn } from "node:child_process";
import { join } from "node:path";

export function start_studio(program, folder, scene) {
  const studio = [program, "studio", ...scene, "--headless", "--device", "cpu", "-o", join(folder, "session")];
  const child = spawn("setpriv", ["--pdeathsig", "KILL", "--", ...studio], { stdio: ["ignore", "pipe", "inherit"] });
  const address = new Promise((found, failed) => {
    let text = "";
    child.stdout.on("data", (bytes) => {
      text += bytes;
      const line = text.match(/http:\/\/127\.0\.0\.1:\d+\/#[0-9a-f]+/);
      if (line) found(line[0]);
    });
    child.on("exit", (code) => failed(new Error(`the studio ended with ${code}`)));
  });
  // An end that nobody waits for is no failure of its own.
  address.catch(() => undefined);
  return { child, address, ended: new Promise((done) => child.on("exit", done)) };
}
