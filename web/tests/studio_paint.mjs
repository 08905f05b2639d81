// Paints a character in the studio: node studio_paint.mjs PROGRAM FOLDER SCENE
// FOLDER gets the session, screenshots and report.json, which says what was seen; the test that runs this judges.
import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { clear_toast, drawn, open_browser, open_page } from "./browser.mjs";
import { pixels_of } from "./png.mjs";
import { start_studio } from "./studio_program.mjs";

const [program, folder, ...scene] = process.argv.slice(2);
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const report = { painted: {}, axe: {} };

let studio = start_studio(program, folder, scene);
const browser = await open_browser();
const { page, said } = await open_page(browser);
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
async function violations() {
  await page.evaluate(axe);
  return page.evaluate(async () =>
    (await window.axe.run(document)).violations.map((one) => `${one.id}: ${one.nodes.map((node) => node.target).join(" ")}`),
  );
}
async function recorded() {
  await page.evaluate(() => delete document.documentElement.dataset.recorded);
  await page.click("#record");
  await wait_for("recorded", null);
  return state("recorded");
}
// Waits until a change of paint is in the flesh.
async function applied(act) {
  const was = await state("applied");
  await act();
  await wait_for("applied", was);
}
const choose_tool = (name) => page.locator(`input[name="tool"][value="${name}"]`).check();
const compare = async (with_what) => {
  await page.evaluate((value) => document.querySelector(`input[name=comparison][value=${value}]`).click(), with_what);
  await drawn(page);
};
const painted = async () => Number(await state("painted"));

await open();
await page.locator("#picture").focus();
if ((await page.getAttribute("#play", "aria-label")) === "Pause") await press(" ");
await page.waitForFunction(() => document.getElementById("play").getAttribute("aria-label") === "Play");
await press("Home");
report.before = await recorded();
if ((await page.getAttribute("#play", "aria-label")) === "Play") await page.click("#play");

// The brush, by mouse: a stroke of fat across the middle of the picture.
await choose_tool("paint");
report.brush = await page.locator("#brush").isVisible();
await page.locator("#picture").focus();
const box = await page.locator("#picture").boundingBox();
const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
// Colours say what is painted: how much of the picture has that of bone. The legend, which has it, is above.
async function bone_pixels() {
  await page.mouse.move(box.x + 4, box.y + 4);
  await clear_toast(page);
  const image = pixels_of(await page.screenshot({ clip: box }));
  let count = 0;
  for (let j = Math.round(image.height / 4); j < image.height; j += 2)
    for (let i = 0; i < image.width; i += 2) {
      const [r, g, b] = image.at(i, j);
      if (r > 120 && r > b + 14 && g > b + 4 && r > g) ++count;
    }
  return count;
}
report.painted.start = await painted();
report.bone_pixels = [await bone_pixels()];
await page.selectOption("#brush-kind", "_LAYER:1");
await applied(async () => {
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let k = 1; k <= 8; ++k) await page.mouse.move(x + 5 * k, y + 2 * k);
  await page.mouse.up();
});
report.painted.stroke = await painted();
report.status = await page.textContent("#toast");
report.axe.paint = await violations();
await page.screenshot({ path: join(folder, "painted.png") });

report.bone_pixels.push(await bone_pixels());

// By keyboard: a larger brush, and a dab of what is rigid.
await page.selectOption("#brush-kind", "_RIGID:1");
await page.locator("#picture").focus();
const radius = await page.textContent("#brush-radius-text");
await press("v");
report.larger = (await page.textContent("#brush-radius-text")) !== radius;
await press("f");
report.smaller = (await page.textContent("#brush-radius-text")) === radius;
await applied(() => press("g"));
report.painted.dab = await painted();

// Fibres along the stroke.
await page.selectOption("#brush-kind", "_FIBER");
report.axe.fibres = await violations();
await applied(async () => {
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let k = 1; k <= 8; ++k) await page.mouse.move(x - 4 * k, y);
  await page.mouse.up();
});
report.painted.fibres = await painted();

// Stiffness: times what the layer says, as its layers are by modulus. In Both what is played is the right half.
await compare("sides");
await page.selectOption("#brush-kind", "_STIFFNESS");
report.times = await page.textContent("#brush-value-text");
await page.locator("#picture").focus();
await applied(() => press("g"));
report.painted.stiffness = await painted();
report.axe.stiffness = await violations();
await applied(() => press("z"));
report.painted.stiffness_undone = await painted();
await compare("flesh");
await page.selectOption("#brush-kind", "_FIBER");

// Undone and redone.
await page.locator("#picture").focus();
await applied(() => press("z"));
report.painted.undone = await painted();
await applied(() => press("y"));
report.painted.redone = await painted();

// Bones: a bone is removed in the list, and another joint is toggled by a click on it, in Both.
await choose_tool("bones");
await page.selectOption("#bone-joint", "forearm");
report.bone = [await page.textContent("#bone-why")];
report.axe.bones = await violations();
await applied(() => page.click("#bone-turn"));
report.bone.push(await page.textContent("#bone-why"));
await applied(() => page.click("#undo"));
report.bone.push(await page.textContent("#bone-why"));
const undo_title = await page.getAttribute("#undo", "title");
const before_click = await state("applied");
let clicked = false;
await compare("sides");
// The arm lies in the middle of the picture.
for (const j of [6, 5, 7, 4, 8, 3, 9, 2, 10, 1, 11, 0])
  for (let i = 0; i < 24 && !clicked; ++i) {
    await page.mouse.click(box.x + (0.5 + (i + 0.5) / 48) * box.width, box.y + ((j + 0.5) * box.height) / 12);
    await drawn(page);
    clicked = (await page.getAttribute("#undo", "title")) !== undo_title;
  }
report.clicked = await page.getAttribute("#undo", "title");
// Otherwise the undo below could end its wait with this change, and the run be recorded without the undo.
await wait_for("applied", before_click);
await compare("flesh");
await page.screenshot({ path: join(folder, "bones.png") });
await applied(() => page.click("#undo"));
await choose_tool("paint");

// What is recorded is what the saved file bakes.
report.recorded = await recorded();
await press("x");
await page.fill("#save-name", "painted.toml");
await page.click("#save-go");
await wait_for("saved", null);
await page.click("#save-close");
await page.locator("#picture").focus();
await press("k");
await page.click("#bake-go");
await wait_for("baked", null);
report.baked = await state("baked");
await page.click("#bake-close");
report.said = [...said];

// The program dies; the next start has the paint.
studio.child.kill("SIGKILL");
await studio.ended;
await page.waitForFunction(() => document.documentElement.dataset.state === "lost");
studio = start_studio(program, folder, scene);
await page.evaluate(() => (document.documentElement.dataset.state = ""));
await page.goto("about:blank");
await open();
await choose_tool("paint");
await page.selectOption("#brush-kind", "_FIBER");
await drawn(page);
report.painted.restored = await painted();
await browser.close();
studio.child.kill("SIGINT");
report.ended = await studio.ended;
writeFileSync(join(folder, "report.json"), JSON.stringify(report, null, 1));
