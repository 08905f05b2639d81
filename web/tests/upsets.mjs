// Opens a page of a body that travels far, and upsets it: node upsets.mjs PAGE.html FOLDER. The report says what was
// seen.
import { writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { drawn, open_browser, open_page } from "./browser.mjs";
import { pixels_of } from "./png.mjs";

const [file, folder] = process.argv.slice(2);
const browser = await open_browser();
const { page, said } = await open_page(browser);
const report = { said };
await page.goto(`file://${resolve(file)}`);
await page.waitForFunction(() => document.documentElement.dataset.state !== undefined);
report.state = await page.evaluate(() => document.documentElement.dataset.state);

const RIM = 56;
async function picture(name) {
  await drawn(page);
  await page.waitForTimeout(400); // a still picture is drawn once more, at full quality
  await drawn(page);
  const png = await page.screenshot({ clip: await page.locator("#picture").boundingBox() });
  writeFileSync(join(folder, `${name}.png`), png);
  return pixels_of(png);
}
const distance = (a, b) => Math.max(Math.abs(a[0] - b[0]), Math.abs(a[1] - b[1]), Math.abs(a[2] - b[2]));
function differing(a, b) {
  let count = 0;
  for (let y = RIM; y < a.height - RIM; ++y)
    for (let x = 0; x < a.width; ++x) if (distance(a.at(x, y), b.at(x, y)) > 3) ++count;
  return count / (a.width * a.height);
}

report.subtitle = await page.textContent("#subtitle");
report.facts = await page.textContent("#facts");

await page.keyboard.press(" ");
await page.keyboard.press("Home");
const before = await picture("before");

// The browser takes the GPU away while a picture is being drawn, and gives it back.
await page.evaluate(async () => {
  const frames = (count) =>
    new Promise((done) => {
      const next = () => (count-- > 0 ? requestAnimationFrame(next) : done());
      next();
    });
  const canvas = document.getElementById("picture");
  const loss = canvas.getContext("webgl2").getExtension("WEBGL_lose_context");
  const told = (event) => new Promise((done) => canvas.addEventListener(event, done, { once: true }));
  document.getElementById("forward").click();
  await frames(2);
  const lost = told("webglcontextlost");
  loss.loseContext();
  await lost;
  await frames(3);
  const restored = told("webglcontextrestored");
  loss.restoreContext();
  await restored;
  await frames(3);
});
await page.keyboard.press("Home");
const after = await picture("after-loss");
report.differs_after_loss = differing(before, after);
// The control: an empty stage differs by the body and the floor.
report.background = differing(before, { ...before, at: () => before.at(RIM, RIM) });

// The floor is under the body in the last frame too.
await page.keyboard.press("End");
report.follows = await page.isChecked("#follow");
const last = await picture("last");
await page.keyboard.press("n");
report.floor_at_last = differing(last, await picture("last-without-floor"));
await page.keyboard.press("n");

// A phone, upright and on its side, and a window as narrow as it is low.
report.sizes = {};
for (const [width, height] of [[390, 664], [740, 360], [390, 400]]) {
  await page.setViewportSize({ width, height });
  await drawn(page);
  await page.screenshot({ path: join(folder, `${width}x${height}.png`) });
  report.sizes[`${width}x${height}`] = await page.evaluate(() => {
    const box = (query) => document.querySelector(query).getBoundingClientRect();
    const aside = document.querySelector("aside");
    const [main, footer] = [box("main"), box("footer")];
    return {
      across: document.documentElement.scrollWidth - window.innerWidth,
      down: document.documentElement.scrollHeight - window.innerHeight,
      scrub: box("#scrub").width / window.innerWidth,
      picture: [box("#picture").width, box("#picture").height],
      // How much of the display options shows above the footer; the rest is scrolled to.
      aside: Math.min(box("aside").bottom, main.bottom, footer.top) - box("aside").top,
      scrolls: aside.scrollHeight <= aside.clientHeight || getComputedStyle(aside).overflowY === "auto",
      outside: [...document.querySelectorAll("footer button, footer input, footer select, header button")]
        .filter((one) => {
          const { left, right, top, bottom, width } = one.getBoundingClientRect();
          const hidden = one.closest(".curves") !== null; // a list that scrolls
          return width > 0 && !hidden && (left < 0 || right > innerWidth || top < 0 || bottom > innerHeight);
        })
        .map((one) => one.id),
      under_footer: box("aside").bottom - footer.top,
    };
  });
}
writeFileSync(join(folder, "report.json"), JSON.stringify(report, null, 1));
await browser.close();
