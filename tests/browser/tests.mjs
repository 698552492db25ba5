// The report page in a real browser: `tests/browser/run`.

import assert from "node:assert/strict";
import { execFileSync, spawn } from "node:child_process";
import { mkdirSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { AGHF, NARROW, ROOT, WIDE, beyondThePage, colours, drawn, launch, open, seek, solve, visit } from "./common.mjs";

const LARGEST = 2e6;
const SCENARIOS = [
  { name: "kinova", joints: 7, limits: false, folder: () => solve("kinova", "kinova_obstacles_01", "--starts", "6"), ghosts: true, search: 2 },
  { name: "digit", joints: 22, limits: false, folder: () => solve("digit", "digit_obstacles_2", "--starts", "3"), ghosts: true, search: 2 },
  { name: "panda", joints: 7, limits: true, folder: () => solve("panda", "robots/panda/scenarios/cage_0001.json", "--tolerance", "0.7", "--starts", "1"), ghosts: true, search: 2 },
];

const tests = [];
const test = (name, body) => tests.push([name, body]);
let browser;

for (const { name, joints, limits, folder, search } of SCENARIOS) {
  let file;
  const page = async (options) => {
    file ??= join(folder(), "report.html");
    return open(browser, file, options);
  };

  test(`${name}: a page of less than 2 MB, no complaint, no request, a picture`, async () => {
    const { page: at, complaints, close } = await page();
    assert.ok(statSync(file).size < LARGEST, `${statSync(file).size} bytes`);
    const { counts } = await colours(at, "canvas");
    assert.ok(Object.keys(counts).length > 12, `the canvas has ${Object.keys(counts).length} colours`);
    assert.deepEqual(complaints, []);
    await close();
  });

  test(`${name}: play moves the robot`, async () => {
    const { page: at, complaints, close } = await page();
    const before = await at.locator("canvas").first().screenshot();
    await at.keyboard.press("Space");
    await at.waitForFunction(() => window.report.state.time > 0.3);
    await at.keyboard.press("Space");
    await drawn(at);
    const time = await at.evaluate(() => window.report.state.time);
    const after = await at.locator("canvas").first().screenshot();
    assert.ok(!before.equals(after), "the picture is the same");
    await at.waitForTimeout(200);
    assert.equal(await at.evaluate(() => window.report.state.time), time, "it goes on after the pause");
    await at.keyboard.press("Home");
    await drawn(at);
    assert.ok(before.equals(await at.locator("canvas").first().screenshot()), "the start looks different the second time");
    assert.deepEqual(complaints, []);
    await close();
  });

  test(`${name}: a curve for each joint, shaded limits, the search`, async () => {
    const { page: at, close } = await page();
    for (const title of ["Position", "Velocity", "Acceleration", "Torque"]) {
      const colors = await at.evaluate((of) => {
        const own = new Set(window.report.views[0].motion.joints.map((joint) => joint.color));
        const lines = document.querySelectorAll(`[data-title="${of}"] polyline`);
        return [...lines].map((line) => line.getAttribute("stroke")).filter((color) => own.has(color));
      }, title);
      assert.equal(new Set(colors).size, joints, `${title} has ${colors.length} curves`);
      assert.equal(colors.length, joints, title);
    }
    const shaded = await at.locator('[data-title="Position"] rect').count();
    assert.equal(shaded > 0, limits, `${shaded} limits are shaded`);
    assert.equal(await at.locator(".panel", { hasText: "The search" }).locator(".plot").count(), search);
    assert.equal(await at.locator(".joints tbody tr").count(), joints);
    assert.match(await at.locator('[data-title="Clearance"] .readout').textContent(), /mm: .+ – .+/);
    await close();
  });

  test(`${name}: a click in a plot moves the robot and all cursors there`, async () => {
    const { page: at, close } = await page();
    const area = at.locator('[data-title="Torque"] .plot-area');
    const box = await area.boundingBox();
    await area.click({ position: { x: 0.7 * box.width, y: 0.5 * box.height } });
    await drawn(at);
    const { time, horizon } = await at.evaluate(() => ({ time: window.report.state.time, horizon: window.report.views[0].motion.horizon }));
    assert.ok(time > 0.55 * horizon && time < 0.75 * horizon, `it is at ${time} of ${horizon} s`);
    const lefts = await at.evaluate(() => [...document.querySelectorAll(".cursor")].map((cursor) => Math.round(cursor.getBoundingClientRect().left - cursor.parentElement.getBoundingClientRect().left)));
    assert.ok(Math.max(...lefts) - Math.min(...lefts) <= 2, `cursors at ${lefts}`);
    assert.ok(Math.abs(lefts[0] - 0.7 * box.width) <= 3, `cursors at ${lefts}, the click at ${0.7 * box.width}`);
    await close();
  });

  test(`${name}: dark and light, wide and narrow, nothing beyond the page`, async () => {
    const means = [];
    for (const viewport of [WIDE, NARROW]) {
      for (const colorScheme of ["light", "dark"]) {
        const { page: at, complaints, close } = await page({ viewport, colorScheme });
        means.push((await colours(at, "body")).mean);
        const beyond = await beyondThePage(at);
        assert.deepEqual(beyond, [], `${viewport.width} ${colorScheme}`);
        assert.deepEqual(complaints, []);
        await close();
      }
    }
    assert.ok(means[0] > 190 && means[2] > 190, `light is ${means}`);
    assert.ok(means[1] < 80 && means[3] < 80, `dark is ${means}`);
  });

  test(`${name}: the time of a frame`, async () => {
    const { page: at, close } = await page();
    const millis = await at.evaluate(async () => {
      const gl = document.querySelector("canvas").getContext("webgl2");
      const { views, state } = window.report;
      const draw = (t) => { views[0].set(t); views[0].view.draw(t, window.report.colors()); gl.finish(); gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); };
      draw(0);
      const from = performance.now();
      for (let i = 0; i < 20; i += 1) draw((i / 20) * views[0].motion.horizon);
      const all = (performance.now() - from) / 20;
      const noScene = performance.now();
      for (let i = 0; i < 200; i += 1) views[0].set((i / 200) * views[0].motion.horizon);
      return { all, script: (performance.now() - noScene) / 200, state: state.time };
    });
    console.log(`    ${name}: ${millis.all.toFixed(1)} ms a frame by a software renderer, ${millis.script.toFixed(2)} ms of it for tables and plots`);
    assert.ok(millis.all < 500, `${millis.all} ms`);
    await close();
  });
}

test("ghosts are drawn where they are asked for, follow and reset move the view", async () => {
  const { page: at, complaints, close } = await open(browser, join(solve("kinova", "kinova_obstacles_01", "--starts", "6"), "report.html"));
  await seek(at, 0.8);
  const shot = () => at.locator("canvas").first().screenshot();
  const before = await shot();
  for (const chip of ["First guess", "Minimum 2", "Obstacles"]) {
    await at.locator(".chip", { hasText: chip }).first().click();
    await drawn(at);
    assert.ok(!before.equals(await shot()), `${chip} changes nothing`);
    await at.locator(".chip", { hasText: chip }).first().click();
    await drawn(at);
  }
  const eye = () => at.evaluate(() => window.report.camera.eye);
  const first = await eye();
  await at.keyboard.press("f");
  await drawn(at);
  assert.notDeepEqual(await eye(), first, "follow");
  await at.keyboard.press("r");
  await drawn(at);
  assert.deepEqual(await eye(), first, "reset");
  const box = await at.locator("canvas").first().boundingBox();
  await at.mouse.move(box.x + 200, box.y + 300);
  await at.mouse.down();
  await at.mouse.move(box.x + 300, box.y + 320, { steps: 4 });
  await at.mouse.up();
  assert.notDeepEqual(await eye(), first, "orbit");
  assert.deepEqual(complaints, []);
  await close();
});

test("the force on a standing foot is drawn in green, and where it does not hold in red", async () => {
  const { page: at, complaints, close } = await open(browser, join(solve("standing", "robots/digit_v3_pinned/digit_stand_stretch.json", "--starts", "1"), "report.html"));
  const color = () => at.evaluate(() => {
    const { views, colors } = window.report;
    const { view } = views[0];
    const [line] = view.foot.lines(view.tracks[0].nearest(window.report.state.time), view.camera.eye, colors());
    return ["good", "bad"].find((name) => colors()[name].every((x, i) => x === line.color[i]));
  });
  await seek(at, 1);
  assert.equal(await color(), "good");
  const shot = () => at.locator("canvas").first().screenshot();
  const before = await shot();
  await at.evaluate(() => window.report.views[0].motion.foot.holds.fill(false));
  await drawn(at);
  assert.equal(await color(), "bad");
  assert.ok(!before.equals(await shot()), "the colour changes nothing");
  await at.locator(".chip", { hasText: "Ground force" }).click();
  await drawn(at);
  const without = await shot();
  assert.ok(!before.equals(without), "there is no arrow");
  assert.deepEqual(complaints, []);
  await close();
});

test("a joint that is chosen is shown alone", async () => {
  const { page: at, close } = await open(browser, join(solve("kinova", "kinova_obstacles_01", "--starts", "6"), "report.html"));
  await at.locator(".joint").nth(2).click();
  assert.equal(await at.locator('[data-title="Torque"] polyline.chosen').count(), 1);
  assert.equal(await at.locator("tr.chosen").count(), 1);
  await at.locator(".joint").nth(2).click();
  assert.equal(await at.locator(".plot.one").count(), 0);
  await close();
});

test("hostile names are text and nothing else", async () => {
  const evil = "</script><script>window.bad=1</script><img src=x onerror=window.bad=1>\"'&amp;😀 {{DATA}}{{TITLE}}";
  const xml = evil.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/"/g, "&quot;");
  const folder = join(ROOT, "target/browser/hostile");
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  const urdf = readFileSync(join(ROOT, "robots/pendulum_2/pendulum_2.urdf"), "utf8");
  const joint = /<joint name="([^"]+)"/.exec(urdf)[1];
  writeFileSync(join(folder, "robot.urdf"), urdf.replace(`<joint name="${joint}"`, `<joint name="${xml}"`));
  const scenario = JSON.parse(execFileSync(AGHF, ["scenarios", "pendulum_2_swingup"]).toString());
  scenario.robot = "robot.urdf";
  scenario.obstacles = [{ name: evil, shape: { sphere: { radius_m: 0.1 } }, pose: { position_m: [3, 3, 3] } }];
  const stem = "</title><script>window.bad=1<".replace(/\//g, "∕");
  writeFileSync(join(folder, `${stem}.json`), JSON.stringify(scenario));
  const { page: at, complaints, close } = await open(browser, join(solve("hostile", join(folder, `${stem}.json`), "--starts", "1"), "report.html"));
  assert.deepEqual(complaints, []);
  assert.equal(await at.evaluate(() => window.bad), undefined);
  assert.equal(await at.locator("h1").textContent(), stem);
  assert.equal(await at.title(), stem);
  assert.equal(await at.locator(".joint").first().textContent(), evil);
  assert.ok((await at.locator(".nearest").textContent()).includes(evil), "the obstacle is named");
  assert.equal(await at.locator("img").count(), 0);
  assert.equal(await at.locator("script").count(), 2);
  await close();
});

test("compare shows two motions with one clock", async () => {
  const one = solve("kinova", "kinova_obstacles_01", "--starts", "6");
  const other = solve("flow", "kinova_obstacles_01", "--method", "flow");
  const file = join(ROOT, "target/browser/out/compare.html");
  execFileSync(AGHF, ["compare", one, other, "-o", file, "--force"]);
  for (const viewport of [WIDE, NARROW]) {
    const { page: at, complaints, close } = await open(browser, file, { viewport });
    const before = await at.locator("canvas").nth(1).screenshot();
    await seek(at, 1);
    assert.ok(!before.equals(await at.locator("canvas").nth(1).screenshot()), "the second robot stands still");
    assert.equal(await at.locator("canvas").count(), 2);
    assert.equal(await at.locator('[data-title="Torque"]').count(), 2);
    assert.equal(await at.locator(".scrub").count(), 1);
    assert.deepEqual(complaints, []);
    await close();
  }
});

test("view serves the page and nothing else", async () => {
  const folder = solve("kinova", "kinova_obstacles_01", "--starts", "6");
  const server = spawn(AGHF, ["view", folder, "--serve"]);
  try {
    const address = await new Promise((done, fail) => {
      let text = "";
      server.stdout.on("data", (data) => {
        text += data;
        const found = /http:\S+/.exec(text);
        if (found) done(found[0]);
      });
      server.on("exit", () => fail(new Error("it ended")));
    });
    const page = await fetch(address);
    assert.equal(page.status, 200);
    assert.equal(await page.text(), readFileSync(join(folder, "report.html"), "utf8"));
    assert.equal((await fetch(`${address}summary.json`)).status, 404);
    assert.equal((await fetch(address, { method: "POST" })).status, 405);
  } finally {
    server.kill();
  }
});

test("a trade-off: a click on the curve shows another motion", async () => {
  const folder = join(ROOT, "target/browser/out/tradeoff");
  const words = ["tradeoff", "limits_01", "--points", "4", "--out", folder, "--force"];
  execFileSync(AGHF, words, { cwd: ROOT, stdio: ["ignore", "ignore", "inherit"] });
  const { page, close } = await open(browser, join(folder, "report.html"));
  const data = await page.evaluate(() => JSON.parse(document.getElementById("data").textContent));
  const horizons = data.motions.map((motion) => motion.horizon);
  const shown = () => page.evaluate(() => window.report.views.map((view) => view.motion.horizon));
  assert.deepEqual(await shown(), [horizons[0]]);
  const [width, height] = await page.locator(".scatter svg").evaluate((svg) => [svg.clientWidth, svg.clientHeight]);
  // The last point is the longest motion of least effort, at the lower right.
  await Promise.all([
    page.waitForEvent("load"),
    page.locator(".scatter svg").click({ position: { x: width - 40, y: height - 60 } }),
  ]);
  await page.waitForFunction(() => window.report);
  assert.deepEqual(await shown(), [horizons[3]]);
  await close();
});

// A sweep in which some sets miss the goal, as the flow is stopped early.
const sweep = () => {
  const folder = join(ROOT, "target/browser/out/sweep");
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  const text = 'method = "flow"\nscenarios = ["pendulum_1_swingup", "pendulum_2_swingup"]\ntime_limit_s = 60\ndegree = [5, 9]\nk = [1e2, 1e5]\ns_max = [1e-9, 0.1]\n';
  writeFileSync(join(folder, "some.toml"), text);
  execFileSync(AGHF, ["sweep", join(folder, "some.toml"), "--out", folder]);
  return join(folder, "report.html");
};

test("a sweep: points, bars, tables that sort and filter, names under the pointer", async () => {
  const file = sweep();
  const { page: at, complaints, close } = await visit(browser, file);
  const results = at.locator('[data-title="Results of all sets"]');
  const rows = results.locator("tbody tr");
  assert.equal(await rows.count(), 16);
  const failed = await results.locator("tr.failed").count();
  assert.ok(failed > 0 && failed < 16, `${failed} of 16 fail`);
  const column = async (name) => {
    const i = await results.locator("th").evaluateAll((heads, of) => heads.findIndex((head) => head.textContent === of), name);
    return results.locator(`tbody td:nth-child(${i + 1})`).allTextContents();
  };
  for (const sign of [1, -1]) {
    await results.getByRole("button", { name: "sort by solve_seconds" }).click();
    const seconds = (await column("solve_seconds")).map(Number);
    assert.deepEqual(seconds, [...seconds].sort((a, b) => sign * (a - b)));
  }
  await results.getByRole("button", { name: "show failures alone" }).click();
  assert.equal(await rows.count(), failed);
  assert.ok((await column("outcome")).every((outcome) => outcome !== "success"));
  await results.getByRole("button", { name: "show failures alone" }).click();
  await results.locator(".filter").fill("pendulum_2 SUCCESS");
  const scenarios = await column("scenario");
  assert.ok(scenarios.length > 0 && scenarios.every((name) => name === "pendulum_2_swingup"), scenarios.join());
  assert.match(await results.locator(".tools .hint").textContent(), new RegExp(`^${scenarios.length} of 16 rows$`));

  assert.equal(await at.locator('[data-title="k"] .value').count(), 2);
  const plot = at.locator(".scatter").first();
  await plot.scrollIntoViewIfNeeded();
  const point = await plot.locator("path.dots").first().evaluate((path) => {
    const [x, y] = path.getAttribute("d").slice(1).split(" ").map(Number);
    const box = path.ownerSVGElement.getBoundingClientRect();
    return [box.left + x, box.top + y];
  });
  await at.mouse.move(...point);
  assert.match(await plot.locator(".tip").textContent(), /^set \d+: pendulum_/);
  assert.deepEqual(complaints, []);
  await close();
  for (const viewport of [WIDE, NARROW]) {
    for (const colorScheme of ["light", "dark"]) {
      const { page: other, complaints: of, close: end } = await visit(browser, file, { viewport, colorScheme });
      await other.waitForSelector("path.dots");
      assert.deepEqual(await beyondThePage(other), [], `${viewport.width} ${colorScheme}`);
      const { mean } = await colours(other, "body");
      assert.ok(colorScheme === "light" ? mean > 190 : mean < 80, `${colorScheme} is ${mean}`);
      assert.deepEqual(of, []);
      await end();
    }
  }
});

browser = await launch();
let failed = 0;
const wanted = process.argv[2] ?? "";
for (const [name, body] of tests.filter(([name]) => name.includes(wanted))) {
  try {
    await body();
    console.log(`ok   ${name}`);
  } catch (error) {
    failed += 1;
    console.log(`FAIL ${name}\n${error.stack}`);
  }
}
await browser.close();
console.log(failed ? `${failed} failed` : "all passed");
process.exit(failed ? 1 : 0);
