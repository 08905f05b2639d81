// Opens an input in the studio and looks whether a body is there and moves: node studio_opens.mjs PROGRAM FOLDER INPUT
import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { drawn, open_browser, open_page } from "./browser.mjs";
import { pixels_of } from "./png.mjs";
import { start_studio } from "./studio_program.mjs";

const [program, folder, ...scene] = process.argv.slice(2);
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const studio = start_studio(program, folder, scene);
const browser = await open_browser();
const { page, said } = await open_page(browser);
await page.goto(await studio.address, { waitUntil: "commit", timeout: 120000 });
await page.waitForFunction(() => document.documentElement.dataset.state === "ready", null, { timeout: 90000 });
const report = { said };
const sequence = () => page.evaluate(() => document.documentElement.dataset.sequence);
const was = await sequence();
await page.waitForFunction((before) => document.documentElement.dataset.sequence !== before, was, { timeout: 30000 });
report.moves = true;
report.can_touch = await page.locator("#save").isEnabled();
await page.keyboard.press("n");
await page.waitForTimeout(1500);
await drawn(page);
const png = await page.screenshot({ clip: await page.locator("#picture").boundingBox() });
writeFileSync(join(folder, "picture.png"), png);
const image = pixels_of(png);
const ground = [...image.at(4, image.height >> 1)];
let body = 0;
for (let y = 60; y < image.height - 60; ++y)
  for (let x = 0; x < image.width; ++x)
    if (image.at(x, y).some((value, c) => Math.abs(value - ground[c]) > 14)) ++body;
report.body = body / (image.width * (image.height - 120));
await page.evaluate(axe);
report.axe = await page.evaluate(async () =>
  (await window.axe.run(document)).violations.map((one) => `${one.id}: ${one.nodes.map((node) => node.target).join(" ")}`),
);
await page.screenshot({ path: join(folder, "page.png") });
await browser.close();
studio.child.kill("SIGINT");
report.ended = await studio.ended;
writeFileSync(join(folder, "report.json"), JSON.stringify(report, null, 1));
