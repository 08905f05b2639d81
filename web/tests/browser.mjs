// Debian's Chromium without a window or a GPU, with all that a page says and asks for written down.
import { chromium } from "playwright-core";

export async function open_browser() {
  return chromium.launch({
    timeout: 120000, // beside other work
    executablePath: process.env.FASCICLE_CHROMIUM ?? "/usr/bin/chromium",
    args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
  });
}

export async function open_page(browser, options = {}) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 720 }, colorScheme: "dark", ...options });
  page.setDefaultTimeout(90000); // a picture in software, beside other work
  const said = [];
  const asked = [];
  page.on("console", (message) => said.push(`${message.type()}: ${message.text()}`));
  page.on("pageerror", (error) => said.push(`error: ${error.message}`));
  page.on("request", (request) => {
    if (!request.url().startsWith("data:") && !request.url().startsWith("blob:")) asked.push(request.url());
  });
  return { page, said, asked };
}

// Takes the message away that lies on the picture and would leave by itself after some seconds.
export async function clear_toast(page) {
  await page.evaluate(() => (document.getElementById("toast").hidden = true));
  await drawn(page);
}

// Once what was asked for is drawn.
export function drawn(page) {
  return page.evaluate(
    () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))),
  );
}
