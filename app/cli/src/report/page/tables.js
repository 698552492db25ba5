// A page of plots and tables.

const data = JSON.parse(document.getElementById("data").textContent);
document.body.classList.add("tables");

const figures = element("dl", "figures", "", data.figures.map(([name, value]) => element("div", "", "", [element("dt", "", name), element("dd", "", value)])));
const title = element("div", "title", "", [element("h1", "", data.title), element("span", "robot", data.about)]);
header.append(element("div", "head", "", [title, figures]));
followTheme(() => {});

const card = (plot) => (plot.kind === "scatter" ? new ScatterCard(plot) : barsCard(plot));
const part = (one) => {
  if (one.kind === "table") return new SortTable(one).root;
  const small = one.plots.every((plot) => plot.kind === "bars");
  return panel(one.title, [element("div", small ? "grid bars" : "grid large", "", one.plots.map((plot) => card(plot).root))]);
};
main.append(element("div", "panels", "", data.parts.map(part)));
// For tests of the page.
window.report = { data };
