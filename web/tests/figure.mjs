// The picture of docs/view.md: node figure.mjs PAGE.html PICTURE.png FRAME
import { resolve } from "node:path";
import { drawn, open_browser, open_page } from "./browser.mjs";

const [file, picture, frame] = process.argv.slice(2);
const browser = await open_browser();
const { page } = await open_page(browser);
await page.goto(`file://${resolve(file)}`);
await page.waitForFunction(() => document.documentElement.dataset.state === "ready");
await page.keyboard.press(" ");
await page.keyboard.press("Home");
for (let k = 0; k < Number(frame); ++k) await page.keyboard.press("ArrowRight");
await page.keyboard.press("b");
await page.keyboard.press("3");
await drawn(page);
await drawn(page);
await page.screenshot({ path: picture });
await browser.close();
