// Starts `fascicle studio` and uses its page as people do:
//   node studio.mjs PROGRAM FOLDER SCENE...
// FOLDER gets the session, screenshots and report.json, which says what was seen; the test that runs this judges.
import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { clear_toast, drawn, open_browser, open_page } from "./browser.mjs";
import { pixels_of } from "./png.mjs";
import { start_studio } from "./studio_program.mjs";

const [program, folder, ...scene] = process.argv.slice(2);
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const report = { keys: {}, axe: {} };

const start = () => start_studio(program, folder, scene);
let studio = start();
const browser = await open_browser();
const { page, said, asked } = await open_page(browser);
const state = (name) => page.evaluate((of) => document.documentElement.dataset[of] ?? null, name);
const wait_for = (name, test) =>
  page.waitForFunction(([of, not]) => (document.documentElement.dataset[of] ?? null) !== not, [name, test], { timeout: 90000 });
async function open() {
  await page.goto(await studio.address, { waitUntil: "commit", timeout: 120000 });
  await page.waitForFunction(() => document.documentElement.dataset.state === "ready", null, { timeout: 90000 });
}
const press = async (key) => {
  await page.keyboard.press(key);
  await drawn(page);
};
const shot = (name) => page.screenshot({ path: join(folder, `${name}.png`) });
async function violations() {
  // The page's policy lets no script in; the debugger's own evaluation is none of the page's.
  await page.evaluate(axe);
  const result = await page.evaluate(() => window.axe.run(document));
  return result.violations.map((one) => `${one.id}: ${one.nodes.map((node) => node.target).join(" ")}`);
}

await open();
report.title = await page.textContent("#title");
await shot("live");
const sequence = await state("sequence");
await wait_for("sequence", sequence);
report.moves = true;
report.axe.touch = await violations();

const paused = () => page.waitForFunction(() => document.getElementById("play").getAttribute("aria-label") === "Play");

// A recorded run from a stand: its hash, and the lowest row of the picture that shows body in its last frame.
async function recorded_bottom(name) {
  if ((await page.getAttribute("#play", "aria-label")) === "Pause") await press(" ");
  await paused();
  await page.evaluate(() => delete document.documentElement.dataset.recorded);
  await page.click("#record");
  await wait_for("recorded", null);
  const hash = await state("recorded");
  await page.waitForFunction((of) => document.documentElement.dataset.hash === of, hash, { timeout: 30000 });
  await drawn(page);
  await clear_toast(page);
  await page.waitForTimeout(1200); // a picture in software takes its time
  const box = await page.locator("#picture").boundingBox();
  const image = pixels_of(await page.screenshot({ clip: box, path: join(folder, `${name}.png`) }));
  const ground = [...image.at(4, 4)];
  let bottom = 0;
  for (let y = 0; y < image.height; ++y)
    for (let x = 60; x < image.width - 60; ++x)
      if (image.at(x, y).some((value, c) => Math.abs(value - ground[c]) > 40)) bottom = y;
  await page.locator("#picture").focus();
  return { hash, bottom };
}

await page.locator("#picture").focus();
await press("n"); // no floor: what is not ground is body
await page.getByRole("button", { name: "Front" }).click();
await page.locator("#picture").focus();
for (let k = 0; k < 6; ++k) await press("-"); // the bar swings far
const first = await recorded_bottom("stiff");

// A slider by keyboard: softer.
const softness = page.getByLabel("flesh.softness slider");
await softness.focus();
const applied = await state("applied");
for (let k = 0; k < 60; ++k) await page.keyboard.press("ArrowRight");
await wait_for("applied", applied);
// Until no further change is applied.
for (let was = applied; (await state("applied")) !== was; await page.waitForTimeout(1500)) was = await state("applied");
report.softness = Number(await page.inputValue("#key-flesh-softness"));
report.toast = await page.textContent("#toast");
const second = await recorded_bottom("soft");
report.bottoms = [first.bottom, second.bottom];
report.hashes = [first.hash, second.hash];
await shot("changed");

// Undo and redo.
await page.locator("#picture").focus();
await press("z");
await page.waitForFunction((was) => document.querySelector("#key-flesh-softness").value !== was, String(report.softness));
report.undone = Number(await page.inputValue("#key-flesh-softness"));
await press("y");
await page.waitForFunction((was) => document.querySelector("#key-flesh-softness").value === was, String(report.softness));

// Save, and bake the saved file.
await press("x");
await page.fill("#save-name", "soft.toml");
await page.click("#save-go");
await wait_for("saved", null);
report.saved = await state("saved");
await shot("save");
report.axe.save = await violations();
await page.click("#save-close");
await page.locator("#picture").focus();
// Another page, like one that was reloaded, can stop the bake too.
const other = (await open_page(browser)).page;
await other.goto(page.url(), { waitUntil: "commit" });
await other.waitForFunction(() => document.documentElement.dataset.state === "ready");
await other.evaluate(() => {
  const stop = document.getElementById("bake-cancel");
  window.could_stop = false;
  new MutationObserver(() => (window.could_stop ||= !stop.hidden)).observe(stop, { attributes: true });
});
await press("k");
await page.click("#bake-go");
await wait_for("baked", null);
await other.waitForFunction(() => document.documentElement.dataset.baked !== undefined);
report.other = await other.evaluate(() => [window.could_stop, document.getElementById("bake-cancel").hidden]);
await other.close();
report.baked = await state("baked");
report.files = await page.locator("#bake-files li").allTextContents();
await shot("baked");
await page.click("#bake-close");
await page.locator("#picture").focus();

// Every key does something.
const checked = (id) => page.evaluate((name) => document.getElementById(name).checked, id);
const choice = (name) => page.evaluate((of) => document.querySelector(`input[name=${of}]:checked`).value, name);
const value = (id) => page.inputValue(`#${id}`);
const camera = async () => (await page.screenshot({ clip: { x: 320, y: 120, width: 700, height: 380 } })).toString("base64");
const clock = () => page.textContent("#clock");
const looks = {
  " ": () => page.getAttribute("#play", "aria-label"),
  ArrowLeft: clock,
  ArrowRight: clock,
  Home: clock,
  l: () => checked("loop"),
  "[": () => value("speed"),
  "]": () => value("speed"),
  2: () => choice("tab"),
  3: () => choice("tab"),
  1: () => choice("tab"),
  h: () => choice("tool"),
  m: () => value("colour"),
  c: () => choice("comparison"),
  b: () => choice("body"),
  u: () => value("cut-axis"),
  ",": () => value("cut"),
  ".": () => value("cut"),
  i: () => checked("fibres"),
  j: () => checked("skeleton"),
  o: () => checked("inverted"),
  e: () => checked("edges"),
  n: () => checked("floor"),
  r: camera,
  t: () => page.evaluate(() => document.documentElement.dataset.theme),
};
for (const key of ["a", "d", "w", "s", "Shift+a", "Shift+d", "Shift+w", "Shift+s", "+", "-"]) looks[key] = camera;
if ((await looks[" "]()) === "Pause") await press(" ");
await page.waitForFunction(() => document.getElementById("play").getAttribute("aria-label") === "Play");
// The panel's keys come first, whatever the order above: names that are digits do. So it must not begin at the first.
await press("3");
const order = Object.keys(looks).filter((key) => key !== " " && key !== "r" && key !== "t");
for (const key of [...order, "r", "t"]) {
  const was = await looks[key]();
  await press(key);
  // What goes over the server takes a moment.
  for (const until = Date.now() + 30000; !report.keys[key] && Date.now() < until; ) {
    await page.waitForTimeout(100);
    report.keys[key] = (await looks[key]()) !== was;
  }
}
await shot("light");
report.axe.light = await violations();
await press("l"); // the loop again
await press(" ");
await page.waitForFunction(() => document.getElementById("play").getAttribute("aria-label") === "Pause");
report.keys[" "] = true;
await press("2");
report.axe.wishes = await violations();
await shot("wishes");
await press("1");
await press("/");
report.keys["/"] = (await page.evaluate(() => document.activeElement.id)) === "find";
await page.keyboard.type("gravity");
report.found = await page.locator("#groups .key:not([hidden])").count();
await page.fill("#find", "");
await page.locator("#picture").focus();
const grip = await state("sequence");
await press("p");
await wait_for("sequence", grip);
report.keys.p = !(await page.textContent("#toast")).includes("No flesh");
await page.waitForTimeout(700);
await press("?");
report.keys["?"] = await page.evaluate(() => document.getElementById("help").open);
report.axe.help = await violations();
report.shown_keys = await page.evaluate(() => document.querySelectorAll("#help-table dt").length);
await shot("help");
await page.keyboard.press("Escape");
report.said = [...said];
report.asked = asked.map((url) => new URL(url).pathname);

// The program dies; the page says so, and the next start has what was changed.
studio.child.kill("SIGKILL");
await studio.ended;
await page.waitForFunction(() => document.documentElement.dataset.state === "lost");
report.lost = await page.textContent("#status");
await shot("lost");
studio = start();
await page.evaluate(() => (document.documentElement.dataset.state = ""));
await page.goto("about:blank");
await open();
report.restored = Number(await page.inputValue("#key-flesh-softness"));
await shot("restored");
await browser.close();
studio.child.kill("SIGINT");
report.ended = await studio.ended;
writeFileSync(join(folder, "report.json"), JSON.stringify(report, null, 1));
