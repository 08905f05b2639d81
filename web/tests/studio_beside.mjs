// Two bakes side by side, on one timeline:
//   node studio_beside.mjs PROGRAM FOLDER BAKE --beside OTHER
// FOLDER gets screenshots and report.json, which says what was seen; the test that runs this judges.
import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { drawn, open_browser, open_page } from "./browser.mjs";
import { hue_of, pixels_of } from "./png.mjs";
import { start_studio } from "./studio_program.mjs";

const [program, folder, ...scene] = process.argv.slice(2);
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const studio = start_studio(program, folder, scene);
const browser = await open_browser();
// A screen with two pixels to one of the page, more than this machine can draw in motion.
const { page, said, asked } = await open_page(browser, { deviceScaleFactor: 2 });
const report = { said, axe: {} };
const html = (name) => page.evaluate((of) => document.documentElement.dataset[of] ?? null, name);
await page.goto(await studio.address, { waitUntil: "commit", timeout: 120000 });
await page.waitForFunction(() => document.documentElement.dataset.state === "ready", null, { timeout: 90000 });
const choice = (name) => page.evaluate((of) => document.querySelector(`input[name=${of}]:checked`).value, name);
const ratio = () =>
  page.evaluate(() => document.getElementById("picture").width / document.getElementById("picture").clientWidth);
const wait_for_ratio = (test, timeout = 120000) =>
  page.waitForFunction(
    ([below]) => {
      const canvas = document.getElementById("picture");
      const has = canvas.width / canvas.clientWidth;
      return below ? has < 1.9 : has >= 1.99;
    },
    [test === "coarse"],
    { timeout },
  );
async function violations() {
  await page.evaluate(axe);
  const result = await page.evaluate(() => window.axe.run(document));
  return result.violations.map((one) => `${one.id}: ${one.nodes.map((node) => node.target).join(" ")}`);
}
const shot = (name) => page.screenshot({ path: join(folder, `${name}.png`), scale: "css" });

// What moves is drawn with fewer pixels where the machine is slow; what stands has all of them.
await page.waitForFunction(() => document.documentElement.dataset.beside !== "");
// The names come with the first picture of both.
await page.waitForFunction(() => document.getElementById("tag-right").textContent !== "");
report.comparison = await choice("comparison");
report.against = await page.inputValue("#against");
report.tags = [await page.textContent("#tag-left"), await page.textContent("#tag-right")];
try {
  await wait_for_ratio("coarse", 20000);
} catch {
  // A machine that is fast enough is slowed down.
  const debugging = await page.context().newCDPSession(page);
  await debugging.send("Emulation.setCPUThrottlingRate", { rate: 20 });
  await wait_for_ratio("coarse");
  await debugging.send("Emulation.setCPUThrottlingRate", { rate: 1 });
}
report.moving_ratio = await ratio();
await page.locator("#picture").focus();
await page.keyboard.press(" ");
await page.waitForFunction(() => document.getElementById("play").getAttribute("aria-label") === "Play");
await wait_for_ratio("full");
report.still_ratio = await ratio();

const last = Number(await page.getAttribute("#scrub", "max"));
async function seek(frame) {
  await page.locator("#scrub").fill(String(frame));
  await page.waitForFunction((number) => document.getElementById("clock").textContent.startsWith(`${number} /`), frame);
  await page.waitForTimeout(1000);
  await wait_for_ratio("full");
  await drawn(page);
}
// Pixels of each half of the picture that `test` takes.
async function count(name, test) {
  await page.waitForTimeout(2500); // a picture in software takes its time
  const box = await page.locator("#picture").boundingBox();
  const image = pixels_of(await page.screenshot({ clip: box, scale: "css", path: join(folder, `${name}.png`) }));
  const found = [0, 0];
  for (let y = 90; y < image.height - 40; ++y)
    for (let x = 0; x < image.width; ++x) if (test(hue_of(image.at(x, y)))) ++found[x < image.width / 2 ? 0 : 1];
  return found;
}
const yellow = ({ hue, saturation, value }) => hue > 45 && hue < 75 && saturation > 0.5 && value > 0.5;
const magenta = ({ hue, saturation, value }) => hue > 290 && hue < 340 && saturation > 0.25 && value > 0.3;

await seek(last);
report.values = await page.locator("#curve-list output").allTextContents();
report.names = await page.locator("#curve-list label > span:not(.line)").allTextContents();
report.curves = await page.getAttribute("#plot", "aria-label");
await shot("sides");
report.axe.dark = await violations();

// The distance of both as colour: on what is played alone.
report.difference_can = await page.locator('#colour option[value="difference"]').isEnabled();
await page.selectOption("#colour", "difference");
await page.locator("#lag-scale").fill("40"); // per cent: what is farthest is beyond its end
report.difference = await count("difference", yellow);
await page.selectOption("#colour", "materials");
report.no_difference = await count("materials", yellow);

// As a ghost over what is played.
await page.selectOption("#colour", "layers");
await page.evaluate(() => document.querySelector('input[name=comparison][value=flesh]').click());
const [alone, ghost] = [await count("alone", magenta), []];
await page.evaluate(() => document.querySelector('input[name=comparison][value=ghost]').click());
// Words on the picture follow with its next drawing.
const tag = async (begin) => {
  await page.waitForFunction((text) => document.getElementById("tag-left").textContent.startsWith(text), begin);
  return page.textContent("#tag-left");
};
report.ghost_tag = await tag("Magenta");
ghost.push(...(await count("ghost", magenta)));
report.ghost = [alone, ghost].map(([left, right]) => left + right);

// By keyboard: none beside, and again the bake.
await page.locator("#picture").focus();
await page.keyboard.press("Shift+B");
await page.waitForFunction(() => document.documentElement.dataset.beside === "");
report.without = {
  tag: await tag("Blue"),
  option: await page.locator('#colour option[value="difference"]').isEnabled(),
};
await page.keyboard.press("Shift+B");
await page.waitForFunction(() => document.documentElement.dataset.beside !== "");
report.again = await html("beside");
await page.keyboard.press("t");
await page.waitForTimeout(1500);
report.axe.light = await violations();
await shot("ghost-light");

// Where a click on the curves lies along the time.
const plot = await page.locator("#plot").boundingBox();
await page.mouse.click(plot.x + 62 + 0.5 * (plot.width - 62), plot.y + plot.height / 2);
await page.waitForFunction((number) => document.getElementById("clock").textContent.startsWith(`${number} /`),
  Math.round(last / 2));
report.clicked = true;
report.asked = asked.map((url) => new URL(url).pathname);
await browser.close();
studio.child.kill("SIGINT");
report.ended = await studio.ended;
writeFileSync(join(folder, "report.json"), JSON.stringify(report, null, 1));
