// A picture of the studio for the docs: node studio_figure.mjs PROGRAM PICTURE.png SCENE [--beside BAKE]
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { drawn, open_browser, open_page } from "./browser.mjs";
import { start_studio } from "./studio_program.mjs";

const [program, picture, ...scene] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), "fascicle-studio-figure-"));
const studio = start_studio(program, folder, scene);
const browser = await open_browser();
const { page } = await open_page(browser);
await page.goto(await studio.address, { waitUntil: "commit", timeout: 120000 });
await page.waitForFunction(() => document.documentElement.dataset.state === "ready", null, { timeout: 90000 });
// The whole clip once, so that the curves are full, and then a frame in which flesh trails.
await page.click("#record");
await page.waitForFunction(() => document.documentElement.dataset.recorded, null, { timeout: 120000 });
await page.locator("#picture").focus();
await page.keyboard.press(" ");
if (scene.includes("--beside")) {
  await page.selectOption("#colour", "difference");
} else {
  await page.selectOption("#colour", "lag");
  await page.check("#skeleton");
}
const last = Number(await page.getAttribute("#scrub", "max"));
await page.locator("#scrub").fill(String(Math.round(0.43 * last)));
await page.waitForFunction(() => document.getElementById("toast").hidden, null, { timeout: 30000 });
await page.waitForTimeout(1500);
await drawn(page);
await page.screenshot({ path: picture });
await browser.close();
studio.child.kill("SIGINT");
await studio.ended;
rmSync(folder, { recursive: true });
