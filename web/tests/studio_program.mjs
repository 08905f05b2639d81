// `fascicle studio` under way, with its session in FOLDER/session.
import { spawn } from "node:child_process";
import { join } from "node:path";

export function start_studio(program, folder, scene) {
  const child = spawn(program, ["studio", ...scene, "--headless", "--device", "cpu", "-o", join(folder, "session")], {
    stdio: ["ignore", "pipe", "inherit"],
  });
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
