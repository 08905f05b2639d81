// The scene's solids in the picture: node studio_solids.mjs PROGRAM FOLDER SCENE, of flesh that falls on a floor.
import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { open_browser, open_page } from "./browser.mjs";
import { hue_of, pixels_of } from "./png.mjs";
import { start_studio } from "./studio_program.mjs";

const [program, folder, ...scene] = process.argv.slice(2);
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const studio = start_studio(program, folder, scene);
const browser = await open_browser();
const { page, said } = await open_page(browser);
const report = { said };
await page.goto(await studio.address, { waitUntil: "commit", timeout: 120000 });
await page.waitForFunction(() => document.documentElement.dataset.state === "ready", null, { timeout: 90000 });
report.can = await page.locator("#solids").isEnabled();
report.title = await page.getAttribute("#solids", "title");
// The whole clip, to its end, where the flesh lies.
await page.click("#record");
await page.waitForFunction(() => document.documentElement.dataset.recorded, null, { timeout: 90000 });
if ((await page.getAttribute("#play", "aria-label")) === "Pause") {
  await page.locator("#picture").focus();
  await page.keyboard.press(" ");
}
await page.waitForFunction(() => document.getElementById("play").getAttribute("aria-label") === "Play");
const touching = () =>
  page.evaluate(() => {
    const row = [...document.querySelectorAll("#facts div")].find((one) => one.firstChild.textContent === "On solids");
    return Number.parseInt(row.lastChild.textContent.replace(",", ""), 10);
  });
async function seek(frame) {
  await page.locator("#scrub").fill(String(frame));
  await page.waitForFunction((number) => document.getElementById("clock").textContent.startsWith(`${number} /`), frame);
  await page.waitForTimeout(2500);
}
const pixels = async (name, is_left = false) => {
  await page.waitForFunction(() => document.getElementById("toast").hidden);
  await page.waitForTimeout(2500); // a picture in software takes its time
  const box = await page.locator("#picture").boundingBox();
  const image = pixels_of(await page.screenshot({ clip: box, path: join(folder, `${name}.png`) }));
  const found = { solid: 0, touch: 0 };
  for (let y = 0; y < image.height; ++y)
    for (let x = 0; x < (is_left ? image.width / 2 : image.width); ++x) {
      const { hue, saturation, value } = hue_of(image.at(x, y));
      if (hue > 238 && hue < 262 && saturation > 0.25 && value > 0.25) ++found.solid;
      if (hue > 15 && hue < 35 && saturation > 0.8 && value > 0.9) ++found.touch;
    }
  return found;
};
await seek(0);
report.above = await touching();
await seek(Number(await page.getAttribute("#scrub", "max")));
report.lying = await touching();
report.shown = await pixels("solids");
await page.locator("#picture").focus();
await page.keyboard.press("Shift+C");
report.unchecked = !(await page.isChecked("#solids"));
report.hidden = await pixels("without");
await page.keyboard.press("Shift+C");
await page.keyboard.press("t");
await page.waitForTimeout(1500);
await page.evaluate(axe);
report.axe = await page.evaluate(async () =>
  (await window.axe.run(document)).violations.map((one) => `${one.id}: ${one.nodes.map((node) => node.target).join(" ")}`),
);
await page.screenshot({ path: join(folder, "light.png") });
// A hand takes hold of what is played, in its own half of the picture.
await page.evaluate(() => document.querySelector('input[name=comparison][value=sides]').click());
await page.waitForTimeout(1500);
await page.locator("#picture").focus();
await page.keyboard.press("p");
await page.waitForTimeout(700);
report.tug = !(await page.textContent("#toast")).includes("No flesh");
report.beside = await pixels("sides", true);
report.names = await page.locator("#curve-list label > span:not(.line)").allTextContents();
await browser.close();
studio.child.kill("SIGINT");
report.ended = await studio.ended;
writeFileSync(join(folder, "report.json"), JSON.stringify(report, null, 1));
