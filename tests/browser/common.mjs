// What tests and pictures share: solves, and pages in a browser.

import { execFileSync } from "node:child_process";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { chromium } from "playwright-core";

export const ROOT = process.env.AGHF_ROOT;
export const AGHF = join(ROOT, "target/release/aghf");
const OUT = join(ROOT, "target/browser/out");

// Solves a scenario and returns the path of its folder.
export const solve = (name, scenario, ...options) => {
  const folder = join(OUT, name);
  mkdirSync(folder, { recursive: true });
  execFileSync(AGHF, ["solve", scenario, "--out", folder, "--force", ...options], { cwd: ROOT, stdio: ["ignore", "ignore", "inherit"] });
  return folder;
};

export const launch = () => chromium.launch({
  executablePath: process.env.AGHF_CHROMIUM,
  headless: true,
  args: [
    "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic",
    "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
  ],
});

export const WIDE = { width: 1440, height: 900 };
export const NARROW = { width: 390, height: 844 };

// A page from disk. What the browser complains of, and any request beside the page itself, is in `complaints`.
export const visit = async (browser, file, { viewport = WIDE, colorScheme = "light", deviceScaleFactor = 1 } = {}) => {
  const context = await browser.newContext({ viewport, colorScheme, deviceScaleFactor, hasTouch: viewport === NARROW });
  const page = await context.newPage();
  const complaints = [];
  page.on("console", (message) => { if (["error", "warning"].includes(message.type())) complaints.push(message.text()); });
  page.on("pageerror", (error) => complaints.push(error.stack));
  page.on("request", (request) => { if (request.url() !== `file://${file}`) complaints.push(`it asks for ${request.url()}`); });
  await page.goto(`file://${file}`);
  await page.waitForFunction(() => window.report);
  return { page, complaints, close: () => context.close() };
};

// The page of a motion at rest at its start.
export const open = async (browser, file, options) => {
  const visited = await visit(browser, file, options);
  await visited.page.evaluate(() => { window.report.play(false); window.report.seek(0); });
  await drawn(visited.page);
  return visited;
};

// What is wider than the page and no part of what scrolls by itself.
export const beyondThePage = (page) => page.evaluate(() => [...document.querySelectorAll("body *")].filter((one) => {
  const box = one.getBoundingClientRect();
  return box.width > 0 && box.right > innerWidth + 1 && !one.closest(".scroll, .chips, svg");
}).map((one) => `${one.tagName}.${one.className}: ${one.textContent.slice(0, 40)}`));

// Waits until what was asked for is drawn.
export const drawn = (page) => page.evaluate(() => new Promise((done) => {
  window.report.redraw();
  requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done)));
}));

export const seek = async (page, time) => {
  await page.evaluate((t) => window.report.seek(t), time);
  await drawn(page);
};

// The number of pixels of an element by colour, at most a thousand colours: how it looks, roughly.
export const colours = async (page, selector) => {
  const shot = await page.locator(selector).first().screenshot();
  return page.evaluate(async (data) => {
    const image = new Image();
    image.src = `data:image/png;base64,${data}`;
    await image.decode();
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const pixels = context.getImageData(0, 0, image.width, image.height).data;
    const counts = {};
    let sum = 0;
    for (let i = 0; i < pixels.length; i += 4) {
      const key = [0, 1, 2].map((k) => pixels[i + k] >> 5).join(",");
      counts[key] = (counts[key] ?? 0) + 1;
      sum += pixels[i] + pixels[i + 1] + pixels[i + 2];
    }
    return { counts, mean: sum / (0.75 * pixels.length) };
  }, shot.toString("base64"));
};
