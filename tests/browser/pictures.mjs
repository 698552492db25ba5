// The pictures of the README, from the page of a motion: `tests/browser/run --pictures`.

import { mkdirSync, statSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import UPNG from "upng-js";
import { ROOT, drawn, launch, open, seek, solve } from "./common.mjs";

const FOLDER = join(ROOT, "examples/pictures");
const FRAMES_PER_SECOND = 16;
const COLOURS = 96;
const LARGEST = 2e6;

mkdirSync(FOLDER, { recursive: true });
const browser = await launch();
const report = join(solve("picture", "kinova_table_01"), "report.html");

// The whole page.
const still = await open(browser, report, { viewport: { width: 1440, height: 860 } });
await seek(still.page, 0.55);
for (const chip of ["First guess"]) await still.page.locator(".chip", { hasText: chip }).first().click();
await drawn(still.page);
await still.page.screenshot({ path: join(FOLDER, "report.png") });
await still.close();

// The view alone, moving.
const moving = await open(browser, report, { viewport: { width: 1040, height: 560 } });
await moving.page.addStyleTag({ content: ".chips, .transport { display: none !important; } .stage { height: 420px !important; } .stage-view { border-radius: 0 !important; border: 0 !important; }" });
const horizon = await moving.page.evaluate(() => {
  window.dispatchEvent(new Event("resize"));
  return window.report.views[0].motion.horizon;
});
await drawn(moving.page);
await moving.page.keyboard.press("r");
const frames = [];
const count = Math.round(horizon * FRAMES_PER_SECOND);
let size = null;
for (let i = 0; i <= count; i += 1) {
  await seek(moving.page, (horizon * i) / count);
  const image = UPNG.decode(await moving.page.locator(".stage-view").screenshot());
  size = [image.width, image.height];
  frames.push(UPNG.toRGBA8(image)[0]);
}
const delays = frames.map((_, i) => (i === count ? 900 : 1000 / FRAMES_PER_SECOND));
const animated = UPNG.encode(frames, ...size, COLOURS, delays);
const file = join(FOLDER, "motion.png");
writeFileSync(file, Buffer.from(animated));
await browser.close();
for (const name of ["report.png", "motion.png"]) console.log(`${name}: ${statSync(join(FOLDER, name)).size} bytes`);
if (statSync(file).size > LARGEST) throw new Error(`${file} is larger than ${LARGEST} bytes`);
