// Opens a page and looks at its layers: node bodies.mjs PAGE.html FOLDER. Writes report.json as view.mjs does.
import { writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { drawn, open_browser, open_page } from "./browser.mjs";
import { hue_of, pixels_of } from "./png.mjs";

const [file, folder] = process.argv.slice(2);
const browser = await open_browser();
const { page, said } = await open_page(browser);
const report = { said, layers: {} };
await page.goto(`file://${resolve(file)}`);
await page.waitForFunction(() => document.documentElement.dataset.state !== undefined);
report.state = await page.evaluate(() => document.documentElement.dataset.state);
report.failure = await page.textContent("#failure");
if (report.state === "ready") {
  await page.keyboard.press(" ");
  await page.keyboard.press("n");
  await page.keyboard.press("2");
  await drawn(page);
  report.ghost = await page.textContent("#ghost-name");
  const png = await page.screenshot({ clip: await page.locator("#picture").boundingBox() });
  writeFileSync(join(folder, "layers.png"), png);
  const image = pixels_of(png);
  const legend = await page.evaluate(() =>
    [...document.querySelectorAll("#legend span")].map((entry) => ({
      name: entry.textContent,
      colour: getComputedStyle(entry.querySelector("i")).backgroundColor.match(/\d+/g).map(Number),
    })),
  );
  // Each pixel of body goes to the layer of the nearest hue and saturation; light changes only the value.
  const flat = (colour) => {
    const { hue, saturation } = hue_of(colour);
    return [saturation * Math.cos((hue * Math.PI) / 180), saturation * Math.sin((hue * Math.PI) / 180)];
  };
  const marks = legend.map((entry) => ({ ...entry, at: flat(entry.colour), count: 0 }));
  const ground = [...image.at(60, image.height >> 1)];
  let body = 0;
  for (let y = 56; y < image.height - 56; ++y)
    for (let x = 0; x < image.width; ++x) {
      const pixel = image.at(x, y);
      if (Math.max(...ground.map((value, c) => Math.abs(value - pixel[c]))) < 12) continue;
      ++body;
      const here = flat(pixel);
      const away = (mark) => Math.hypot(mark.at[0] - here[0], mark.at[1] - here[1]);
      const nearest = marks.reduce((best, mark) => (away(mark) < away(best) ? mark : best));
      if (away(nearest) < 0.2) ++nearest.count;
    }
  for (const mark of marks) report.layers[mark.name] = mark.count / body;
}
writeFileSync(join(folder, "report.json"), JSON.stringify(report, null, 1));
await browser.close();
