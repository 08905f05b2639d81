// Opens a page of `fascicle view` from disk and uses it as people do, by mouse and by keyboard:
//   node view.mjs PAGE.html FOLDER LEAST MOST
// LEAST and MOST are the frames of the least and of the most lag. Screenshots and report.json, which says what was
// seen, go to the folder; the test that runs this judges.
import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";
import { drawn, open_browser, open_page } from "./browser.mjs";
import { hue_of, pixels_of } from "./png.mjs";

const [file, folder, least, most] = process.argv.slice(2);
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const browser = await open_browser();
const { page, said, asked } = await open_page(browser, { bypassCSP: false });
const report = { said, asked, keys: {}, axe: {}, pictures: {} };

await page.goto(`file://${resolve(file)}`);
await page.waitForFunction(() => document.documentElement.dataset.state !== undefined);
report.state = await page.evaluate(() => document.documentElement.dataset.state);

const frame = () => page.evaluate(() => Number(document.getElementById("scrub").value));
const is_checked = (id) => page.evaluate((name) => document.getElementById(name).checked, id);
const choice = (name) => page.evaluate((of) => document.querySelector(`input[name=${of}]:checked`).value, name);
const press = async (key) => {
  await page.keyboard.press(key);
  await drawn(page);
};

// It plays by itself; the keyboard stops it and lets it go on.
const before = await frame();
await page.waitForFunction((was) => Number(document.getElementById("scrub").value) !== was, before);
report.plays = true;
await press(" ");
const stopped = await frame();
await page.waitForTimeout(300);
report.stays = (await frame()) === stopped;

// Scrubbing by the mouse, on the slider and on the curves.
const middle_of = async (id, share) => {
  const box = await page.locator(`#${id}`).boundingBox();
  return [box.x + share * box.width, box.y + box.height / 2];
};
await page.mouse.click(...(await middle_of("scrub", 0.5)));
report.scrubbed = await frame();
if (await page.locator("#plot").isVisible()) {
  await page.mouse.click(...(await middle_of("plot", 0.25)));
  report.scrubbed_on_curves = await frame();
}
await page.locator("#picture").focus();

async function go_to(wanted) {
  await press("Home");
  for (let k = 0; k < Math.floor(wanted / 10); ++k) await page.keyboard.press("Shift+ArrowRight");
  for (let k = 0; k < wanted % 10; ++k) await page.keyboard.press("ArrowRight");
  await drawn(page);
  if ((await frame()) !== wanted) throw new Error(`frame ${await frame()} in place of ${wanted}`);
}

// What a picture of the canvas shows; `name` is kept as a file.
async function picture(name) {
  const box = await page.locator("#picture").boundingBox();
  const png = await page.screenshot({ clip: box });
  writeFileSync(join(folder, `${name}.png`), png);
  return pixels_of(png);
}
const distance = (a, b) => Math.max(Math.abs(a[0] - b[0]), Math.abs(a[1] - b[1]), Math.abs(a[2] - b[2]));
// Words and legends lie over the picture's rim; the middle is the body's.
const RIM = 56;
function measured(image, from = 0, to = 1) {
  const ground = [...image.at(RIM, image.height >> 1)];
  const seen = { pixels: 0, body: 0, hues: new Array(36).fill(0), bright: 0, blue: 0, box: [1e9, 1e9, -1, -1] };
  for (let y = RIM; y < image.height - RIM; ++y)
    for (let x = Math.floor(image.width * from); x < Math.floor(image.width * to); ++x) {
      ++seen.pixels;
      const pixel = image.at(x, y);
      if (distance(pixel, ground) < 12) continue;
      ++seen.body;
      const { hue, saturation, value } = hue_of(pixel);
      if (saturation > 0.35) ++seen.hues[Math.floor(hue / 10) % 36];
      if (hue > 45 && hue < 170 && saturation > 0.35 && value > 0.3) ++seen.bright;
      if (hue > 195 && hue < 230 && saturation > 0.25) ++seen.blue;
      seen.box = [
        Math.min(seen.box[0], x),
        Math.min(seen.box[1], y),
        Math.max(seen.box[2], x),
        Math.max(seen.box[3], y),
      ];
    }
  return seen;
}
function differing(a, b) {
  let count = 0;
  for (let y = RIM; y < a.height - RIM; ++y)
    for (let x = 0; x < a.width; ++x) if (distance(a.at(x, y), b.at(x, y)) > 12) ++count;
  return count;
}

await press("n"); // without the floor, what is not ground is body
const home = await page.screenshot();
writeFileSync(join(folder, "page.png"), home);
await page.getByRole("button", { name: "Front" }).click();
await go_to(0);
report.pictures.front = measured(await picture("front"));
await page.getByRole("button", { name: "¾" }).click();
await go_to(Number(most));
const flesh = await picture("flesh");
report.pictures.flesh = measured(flesh);
await press("g");
const ghost = await picture("ghost");
report.pictures.ghost = measured(ghost);
report.ghost_differs = differing(flesh, ghost);
await press("b");
const sides = await picture("sides");
report.pictures.left = measured(sides, 0, 0.5);
report.pictures.right = measured(sides, 0.5, 1);
let apart = 0;
const half = sides.width / 2;
for (let y = RIM; y < sides.height - RIM; ++y)
  for (let x = 0; x < half; ++x) if (distance(sides.at(x, y), sides.at(x + half, y)) > 12) ++apart;
report.sides_differ = apart;
await press("c");
await press("2");
report.pictures.layers = measured(await picture("layers"));
await press("3");
report.pictures.most_lag = measured(await picture("lag"));
report.axe.dark = await violations();
await go_to(Number(least));
report.pictures.least_lag = measured(await picture("least-lag"));
await press("1");

async function violations() {
  // The page's policy lets no script in; the debugger's own evaluation is none of the page's.
  await page.evaluate(axe);
  const result = await page.evaluate(() => window.axe.run(document));
  return result.violations.map((one) => `${one.id}: ${one.nodes.map((node) => node.target).join(" ")}`);
}

// Every key of the help does something; what, is looked at one by one.
const camera = async () => {
  const png = await page.screenshot({ clip: { x: 300, y: 100, width: 420, height: 380 } });
  return png.toString("base64");
};
const clock = async () => String(await frame());
const looks = {
  " ": () => page.getAttribute("#play", "aria-label"),
  ArrowLeft: clock,
  ArrowRight: clock,
  "Shift+ArrowLeft": clock,
  "Shift+ArrowRight": clock,
  Home: clock,
  End: clock,
  l: () => is_checked("loop"),
  "[": () => page.inputValue("#speed"),
  "]": () => page.inputValue("#speed"),
  1: () => choice("colouring"),
  2: () => choice("colouring"),
  3: () => choice("colouring"),
  ",": () => page.inputValue("#lag-scale"),
  ".": () => page.inputValue("#lag-scale"),
  c: () => choice("comparison"),
  g: () => choice("comparison"),
  b: () => choice("comparison"),
  e: () => is_checked("edges"),
  n: () => is_checked("floor"),
  a: camera,
  d: camera,
  w: camera,
  s: camera,
  "Shift+a": camera,
  "Shift+d": camera,
  "Shift+w": camera,
  "Shift+s": camera,
  "+": camera,
  "-": camera,
  v: camera,
  r: camera,
  f: () => is_checked("follow"),
  t: () => page.evaluate(() => document.documentElement.dataset.theme),
  "?": () => page.evaluate(() => document.getElementById("help").open),
};
await page.locator("#picture").focus();
await go_to(Math.min(20, Math.floor((await page.evaluate(() => Number(document.getElementById("scrub").max))) / 2)));
// "1" must find something else chosen, and Home and End the middle.
const order = ["b", "g", "c", "3", ",", ".", "2", "1", "ArrowRight", "ArrowLeft", "Shift+ArrowRight", "Shift+ArrowLeft", "Home", "End"];
for (const key of [...order, ...Object.keys(looks).filter((one) => !order.includes(one) && one !== "?"), "?"]) {
  const was = await looks[key]();
  await press(key);
  report.keys[key] = (await looks[key]()) !== was;
  if (key === " ") await press(" ");
}
report.pressed = Object.keys(looks);
report.shown_keys = await page.evaluate(() => document.querySelectorAll("#help-table dt").length);
report.axe.help = await violations();
await page.screenshot({ path: join(folder, "help.png") });
await press("Escape");
report.help_closed = !(await page.evaluate(() => document.getElementById("help").open));
report.axe.light = await violations();
await page.screenshot({ path: join(folder, "light.png") });

// Each control is reached by the Tab key and lies within the window.
const controls = await page.evaluate(
  () => document.querySelectorAll("button:enabled, input:enabled, select:enabled, summary, canvas[tabindex]").length,
);
const reached = new Set();
await page.evaluate(() => document.activeElement?.blur());
for (let k = 0; k < controls + 5; ++k) {
  await page.keyboard.press("Tab");
  reached.add(
    await page.evaluate(() => {
      const one = document.activeElement;
      const name = one?.name || one?.id || one?.dataset.view || one?.tagName || "";
      return one?.type === "checkbox" && !one.id ? `curve ${one.parentElement.textContent}` : name;
    }),
  );
}
report.reached = [...reached];
report.overflows = await page.evaluate(() => ({
  across: document.documentElement.scrollWidth - window.innerWidth,
  down: document.documentElement.scrollHeight - window.innerHeight,
  outside: [...document.querySelectorAll("footer button, footer input, footer select, header button")]
    .filter((one) => {
      const box = one.getBoundingClientRect();
      return box.width > 0 && (box.left < 0 || box.right > window.innerWidth || box.bottom > window.innerHeight);
    })
    .map((one) => one.id),
}));
writeFileSync(join(folder, "report.json"), JSON.stringify(report, null, 1));
await browser.close();
